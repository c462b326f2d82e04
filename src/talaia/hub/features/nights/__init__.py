"""Features of nights that run by themselves."""
