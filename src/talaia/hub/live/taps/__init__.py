"""Raw topics of robots for those at the hub who want them: each once from its gateway."""
