"""``talaia plan``: nights from files."""
