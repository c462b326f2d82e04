"""ROS 2 in a process of another Python: the standard library and rclpy, and nothing of Talaia's."""
