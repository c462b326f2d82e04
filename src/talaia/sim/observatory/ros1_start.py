"""Hands over to the machine's own Python, which is the one that has ROS 1."""

from __future__ import annotations

import os
import sys
from pathlib import Path

__all__ = ["PYTHON", "ros1_environment", "run_ros1"]

PYTHON = "/usr/bin/python3"
# What belongs to this Python and would be wrong in the other one.
_OURS = ("PYTHONPATH", "PYTHONHOME", "LD_LIBRARY_PATH", "VIRTUAL_ENV")


def ros1_environment() -> dict[str, str]:
    """Give the environment without what belongs to this Python."""
    return {key: value for key, value in os.environ.items() if key not in _OURS}


def run_ros1(module: str, words: list[str]) -> int:
    """Become ``module`` (``ros1_shell``, ``ros1_client``) under the machine's Python.

    Comes back only when that cannot be, with 1.
    """
    main = str(Path(__file__).with_name("ros1_main.py"))
    if not Path(PYTHON).exists():
        sys.stderr.write(f"talaia sim: there is no {PYTHON}, which ROS 1 needs\n")
        return 1
    # What Python still holds back would be lost with this program.
    sys.stdout.flush()
    os.execve(PYTHON, [PYTHON, main, module, *words], ros1_environment())  # noqa: S606 - no shell
    return 1
