"""Pages that are connected now: their sockets, rights, subscriptions and commands."""
