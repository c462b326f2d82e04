"""Views and plain rows for people with an SQL client."""
