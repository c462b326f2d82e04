"""Files of robots, such as meshes: from the hub's folder, its cache, or the robot's gateway."""
