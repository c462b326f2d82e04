"""A simulated observatory. Its models need the standard library only, as ROS 1's Python has it."""
