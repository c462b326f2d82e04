"""The WebSocket API of the founding observatory, served by the gateway."""
