"""Interlocks, enclosures and link-loss policies: what keeps people and hardware safe."""
