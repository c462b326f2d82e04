"""Digital twins: simulated vehicles beside real ones."""
