"""Tries made message classes in a process of its own, before any is used in the gateway's.

A class whose C structs do not fit this ROS ends its process, or hangs it so that SIGTERM is not
heard. The child publishes a text with its real class and takes it by a made one, in a domain that
robots do not use; whatever it does, it is ended with SIGKILL. Where ROS 2 is a system's, the child
is of that ROS's own Python: the bridge itself drives and must not wait for a trial.
"""

from __future__ import annotations

import os
import select
import subprocess
import sys
import threading
import time

from talaia.gateway.adapters.ros2.system_ros.process import BRIDGE_SCRIPT
from talaia.gateway.adapters.ros2.system_ros.shared_process import SHARED
from talaia.ros_installation import bridge_environment, use_ros

__all__ = ["self_test_problem"]

# The highest domains have ports that nothing else on a Linux machine is given.
_DOMAIN = 231
_PATIENCE_S = 20.0
# As `rclpy_bridge.class_trial` says it; not imported, for that imports rclpy.
_PASSED = "made classes work"
_lock = threading.Lock()
# What came of it; empty when it passed. None until it has been run.
_outcome: str | None = None


def self_test_problem() -> str:
    """Tell why made classes cannot be used here; empty where they can.

    Runs once in a process, and takes about two seconds: not for a thread that must not wait.
    """
    global _outcome
    with _lock:
        if _outcome is None:
            _outcome = _run_child()
        return _outcome


def _run_child() -> str:
    if SHARED.in_use:
        command = [*SHARED.python_command(), str(BRIDGE_SCRIPT), "class-trial"]
        kept = bridge_environment(os.environ)
    else:
        command, kept = [sys.executable, "-m", __name__], dict(os.environ)
    environment = {
        **kept,
        "ROS_DOMAIN_ID": str(_DOMAIN),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    }
    # Robots elsewhere must not be met.
    environment.pop("ROS_STATIC_PEERS", None)
    with subprocess.Popen(  # noqa: S603 - this module, or the bridge's own
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=environment,
    ) as child:
        assert child.stdout is not None  # noqa: S101 - it is a pipe
        try:
            said = _read_until_closed(child.stdout.fileno())
        finally:
            child.kill()
    if _PASSED in said:
        return ""
    return "a trial of reading types by name failed with this version of ROS"


def _read_until_closed(stream: int) -> str:
    """Read what the child says, until it has passed, ends or takes too long."""
    said, until = b"", time.monotonic() + _PATIENCE_S
    while (left := until - time.monotonic()) > 0 and _PASSED.encode() not in said:
        if not select.select([stream], [], [], left)[0]:
            break
        more = os.read(stream, 4096)
        if not more:
            break
        said += more
    return said.decode(errors="replace")


if __name__ == "__main__":
    use_ros()
    # ROS's libraries are to be found first.
    from talaia.gateway.adapters.ros2.rclpy_bridge.class_trial import main

    main()
