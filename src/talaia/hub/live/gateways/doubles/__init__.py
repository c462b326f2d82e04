"""Two gateways with one key: who has the place, and who waits."""
