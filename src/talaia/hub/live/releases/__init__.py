"""Releases for gateways: the hub keeps them, and hands them out in stages."""
