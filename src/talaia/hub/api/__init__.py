"""What the hub answers over HTTP, and the doors of its sockets."""
