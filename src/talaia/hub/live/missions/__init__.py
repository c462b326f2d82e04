"""Missions that run: at the hub, each with the rights of an account."""
