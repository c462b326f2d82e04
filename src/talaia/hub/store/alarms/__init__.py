"""Alarms in the database, and messages about them."""
