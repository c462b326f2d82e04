"""One server for each device of the simulated observatory, for ROS 1 and ROS 2 alike."""
