"""The ROS 2 adapter, on a wait set of its own."""
