"""Files that the robot's description names, such as meshes, for a hub that asks for them."""
