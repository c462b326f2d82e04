"""What of a robot is a signal, a command, a drive, and why the rest is none."""
