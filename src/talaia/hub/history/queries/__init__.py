"""Windows of the history read back: points, statistics, tables."""
