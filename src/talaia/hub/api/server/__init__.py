"""What stands before every route: connections, limits, proxies, headers."""
