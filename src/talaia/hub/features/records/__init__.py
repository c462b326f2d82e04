"""Features of what the hub has kept: how much it is, and what is imported into it."""
