"""The MQTT adapter: topics of a broker."""
