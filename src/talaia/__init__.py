"""Talaia: a self-hosted control room for robots and robotic observatories."""

__version__ = "0.1.0"
