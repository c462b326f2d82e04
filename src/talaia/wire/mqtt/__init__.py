"""What is said by MQTT: names of topics, payloads, Home Assistant's discovery. No I/O here."""
