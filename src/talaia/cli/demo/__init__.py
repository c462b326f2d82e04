"""The demonstrations: simulated robots, a hub and a gateway in one command."""
