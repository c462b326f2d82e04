"""How a message reaches a person: ways out, what may be reached by them, and the outbox's run."""
