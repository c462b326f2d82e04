"""Programs of a robot that send by Socket.IO, to a server of the gateway's own."""
