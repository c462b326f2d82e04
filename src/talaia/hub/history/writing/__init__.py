"""The thread that writes, and what it writes."""
