"""A simulated observatory that lives through its nights many times as fast as they go by."""
