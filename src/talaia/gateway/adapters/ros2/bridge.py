"""Starts a system's ROS 2 for a gateway. Run as a script by that ROS's own Python, 3.8 or later.

With the word ``class-trial`` it tries made message classes and ends; with ``service-caller`` and
the name of a node it calls services whose types are not installed. What it does is in the package
`rclpy_bridge` beside this file. Neither imports anything of talaia: the other Python has none of
what that needs.
"""

from __future__ import annotations

import sys

# Only found here, in the script's own folder, which stands first; its modules come below.
import rclpy_bridge  # noqa: F401

# Our `actions`, `services` and `parameters` would hide packages of the same names.
sys.path.pop(0)

if __name__ == "__main__":
    # In a process of its own, so that what it may break is not what drives a robot.
    if sys.argv[1:] == ["class-trial"]:
        from rclpy_bridge.class_trial import main

        main()
    elif sys.argv[1:2] == ["service-caller"]:
        from rclpy_bridge.service_caller import main as call_services

        call_services(sys.argv[2])
    else:
        from rclpy_bridge.main import main as join

        join()
