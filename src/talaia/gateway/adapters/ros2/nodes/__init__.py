"""Nodes of a robot: their parameters, their life cycles, what they write to the log."""
