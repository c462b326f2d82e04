"""Maps: the ground under the robots, what a site draws on it, and where each site is."""
