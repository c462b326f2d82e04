"""The ROS 1 adapter, with its node in a process of its own."""
