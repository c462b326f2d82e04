"""Missions: what a robot does step by step, as values."""
