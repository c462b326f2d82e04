"""Seeing things on pictures: a detector's input and output, and what was seen from when to when."""
