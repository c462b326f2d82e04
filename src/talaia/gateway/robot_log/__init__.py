"""The robot's own log, kept until the hub has it."""
