"""An independent process that closes enclosures when the gateway is dead or stands still."""
