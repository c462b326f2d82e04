"""Releases of gateways, for admins."""
