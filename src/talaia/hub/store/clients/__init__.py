"""Client protocols in the database."""
