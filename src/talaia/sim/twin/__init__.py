"""The digital twin of a real vehicle: the simulated one, drawn towards where that one is."""
