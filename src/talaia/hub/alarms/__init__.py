"""Alarms, decided from values and times alone: no socket, clock or database is known here."""
