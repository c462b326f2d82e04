"""Frames of a night: their arguments, their files, and darks while the roof is closed."""
