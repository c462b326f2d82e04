"""Interlocks, enclosures, outlets and overrides as values, and what follows from them."""
