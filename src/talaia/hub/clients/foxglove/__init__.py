"""The hub as a Foxglove WebSocket server."""
