"""Clients of other tools: connections, driving, which protocols are open."""
