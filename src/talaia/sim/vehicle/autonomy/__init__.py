"""How the vehicle drives by itself to where it is sent."""
