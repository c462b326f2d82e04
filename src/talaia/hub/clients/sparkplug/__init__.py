"""The hub as an edge node of Sparkplug B, at the broker of the MQTT bridge."""
