"""The hub as a Socket.IO server, for the founding vehicle's own clients and for newer ones."""
