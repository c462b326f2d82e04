"""To be imported before anything of ROS 2: makes ``rclpy`` importable; see `ros_installation`."""

from __future__ import annotations

from talaia.ros_installation import use_ros

__all__: list[str] = []

# May start the process anew, with the same number and arguments.
use_ros()
