"""What hub and gateway ask of their own process: memory, time slices, the event loop."""
