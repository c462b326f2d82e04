"""Starts a system's ROS 2 for a gateway. Run as a script by that ROS's own Python, 3.8 or later.

What it does is in the package `rclpy_bridge` beside this file. Neither imports anything of talaia:
the other Python has none of what that needs.
"""

from __future__ import annotations

import sys

# Only found here, in the script's own folder, which stands first; its modules come below.
import rclpy_bridge  # noqa: F401

# Our `actions`, `services` and `parameters` would hide packages of the same names.
sys.path.pop(0)

from rclpy_bridge.main import main

if __name__ == "__main__":
    main()
