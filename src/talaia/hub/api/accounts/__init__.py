"""Accounts over HTTP: signing in, one's own account, people, roles, tokens."""
