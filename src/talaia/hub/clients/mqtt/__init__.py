"""Publishing to an MQTT broker of the user's, and commands from it."""
