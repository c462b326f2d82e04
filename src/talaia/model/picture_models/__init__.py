"""Models of one's own that tell of a camera's pictures something else than boxes. Values only."""
