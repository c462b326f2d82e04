"""Starts `rclpy_bridge.service_caller` where ROS 2 is of this Python: with the name of its node."""

from __future__ import annotations

import sys

from talaia.ros_installation import use_ros

__all__: list[str] = []


if __name__ == "__main__":
    use_ros()
    # ROS's libraries are to be found first.
    from talaia.gateway.adapters.ros2.rclpy_bridge.service_caller import main

    main(sys.argv[1])
