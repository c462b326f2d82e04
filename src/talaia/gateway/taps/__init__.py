"""Raw topics for the hub, each heard on the robot only while somebody wants it."""
