"""Every sample kept, and any window of it read back at the width of a chart."""
