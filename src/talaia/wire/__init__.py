"""Bytes to values and back, for every message between gateway, hub and browser; no sockets."""
