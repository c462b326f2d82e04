"""Several hubs as one: who leads, and how requests reach it through the others."""
