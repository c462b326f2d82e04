"""A system's ROS 2 of another Python: stand-ins for rclpy whose work a bridge process does."""
