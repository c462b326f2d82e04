"""Starts the node of the ROS 1 adapter. Run as a script by the Python that has rospy, 3.8 or later.

The node itself is the package `rospy_bridge` beside this file. Neither imports anything of talaia:
the other Python has none of what that needs.
"""

from __future__ import annotations

import sys

# Only found here, in the script's own folder, which stands first; its modules come below.
import rospy_bridge  # noqa: F401

# Our `node`, `frames` and `master` would hide ROS's packages of the same names.
sys.path.pop(0)

from rospy_bridge.main import main

if __name__ == "__main__":
    main()
