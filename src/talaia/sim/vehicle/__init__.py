"""A TurtleBot3-like vehicle in a furnished house, as ordinary ROS 2 topics."""
