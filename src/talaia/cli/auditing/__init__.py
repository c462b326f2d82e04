"""``talaia audit``: what can be done with a hub's audit log."""
