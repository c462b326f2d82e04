"""What the vehicle tells of itself and its house once: its form, and a map."""
