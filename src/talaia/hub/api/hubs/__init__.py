"""The hubs that are one, for admins."""
