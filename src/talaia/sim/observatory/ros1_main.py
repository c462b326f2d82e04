"""Runs a part of the observatory under the machine's own Python: ``ros1_main.py MODULE WORDS…``."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

# Last, so that the machine's own packages of ROS 1 win over wheels of ROS 2 that lie beside ours;
# and not this folder, whose modules have names of their own.
sys.path[0:1] = []
sys.path.append(str(Path(__file__).resolve().parents[3]))

if __name__ == "__main__":
    try:
        import numpy as np  # noqa: F401
        import rospy  # noqa: F401
    except ImportError as error:
        sys.stderr.write(
            f"talaia sim: ROS 1 cannot be imported ({error}); "
            "install Debian's python3-rospy, python3-rosmaster and python3-numpy\n"
        )
        sys.exit(1)
    module = import_module(f"talaia.sim.observatory.{sys.argv[1]}")
    sys.exit(module.main(sys.argv[2:]))
