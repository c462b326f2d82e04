"""Routes and sockets of client protocols."""
