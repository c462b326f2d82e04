"""``talaia move-files``."""
