"""How the vehicle's wheels move it, and what an arm on it does."""
