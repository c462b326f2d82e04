"""Lines of Engine.IO to clients, and what carries them; the packets are in `wire.socketio`."""
