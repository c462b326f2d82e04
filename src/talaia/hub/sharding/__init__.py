"""Sites of several hubs, divided among leads: which shard has which, and what crosses them."""
