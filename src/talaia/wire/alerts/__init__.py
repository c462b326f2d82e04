"""Notices of transients, as GCN and VOEvent send them: bytes to values, and filters over these."""
