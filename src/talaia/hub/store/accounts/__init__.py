"""People in the database: accounts, roles, sessions, tokens."""
