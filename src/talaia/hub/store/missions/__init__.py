"""Missions in the database."""
