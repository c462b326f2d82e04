"""What differs between databases: one file for each engine, behind one protocol."""
