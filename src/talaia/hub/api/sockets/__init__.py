"""WebSockets of pages and gateways."""
