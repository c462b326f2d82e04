"""The gateway's own way to people: what is critical, while the hub is away."""
