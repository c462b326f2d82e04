"""Driving a device: its lease, velocity limits, dead man's zero and STOP."""
