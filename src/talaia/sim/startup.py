"""How a simulated robot starts and ends: its ROS domain, signals, and the line that says ready."""

from __future__ import annotations

import json
import logging
import os
import signal
import sys
import threading
import time
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING

from talaia.ros_installation import ForeignRos, use_ros
from talaia.shared_memory import remove_dead_segments_at_start
from talaia.sim.errors import RosMissing, SimError
from talaia.sim.ros_domain import domain_environment, reserve_domain

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

__all__ = ["Start", "join_ros", "needing_ros", "run_robot"]


class Start:
    """One start of a robot.

    Attributes:
        domain: the ROS domain it lives in.
        ended: set by SIGINT and SIGTERM.
        stack: what was built is ended by it, last built first.

    """

    def __init__(self, domain: int, ended: threading.Event, stack: ExitStack) -> None:
        """Count from now."""
        self.domain, self.ended, self.stack = domain, ended, stack
        self._began = time.monotonic()

    def say_ready(self, **more: object) -> None:
        """Print the one JSON line that whoever started us waits for."""
        line = {
            "ready": True,
            "domain": self.domain,
            "pid": os.getpid(),
            **more,
            "seconds": round(time.monotonic() - self._began, 2),
        }
        sys.stdout.write(json.dumps(line) + "\n")
        sys.stdout.flush()


def run_robot(
    name: str, domain: int | None, run: Callable[[Start], None], *, shared: bool = False
) -> int:
    """Run a robot until SIGINT or SIGTERM.

    Args:
        name: as it is called on the command line, after ``talaia``.
        domain: reserved by whoever starts us; none reserves a free one.
        run: builds it and runs it until `Start.ended`.
        shared: the domain is that of a real robot, which may be on another machine: it is joined
            as this machine's ROS joins it. None takes the environment's.

    Returns:
        0 after a signal, 1 when it cannot run here.

    """
    logging.basicConfig(level=logging.INFO, stream=sys.stderr, format="%(name)s: %(message)s")
    ended = threading.Event()
    try:
        with ExitStack() as stack:
            # No more than an event: all is ended by the main thread, in order.
            for number in (signal.SIGINT, signal.SIGTERM):
                before = signal.signal(number, lambda *_: ended.set())
                # Put back as they were, for a caller that goes on.
                stack.callback(signal.signal, number, before)
            if shared:
                domain = int(os.environ.get("ROS_DOMAIN_ID", "0")) if domain is None else domain
                os.environ["ROS_DOMAIN_ID"] = str(domain)
            else:
                if domain is None:
                    domain = stack.enter_context(reserve_domain()).domain
                # For this process and whatever it starts.
                os.environ.update(domain_environment(domain))
            run(Start(domain, ended, stack))
    except (SimError, OSError) as error:
        sys.stderr.write(f"talaia {name}: {error}\n")
        return 1
    return 0


@contextmanager
def needing_ros() -> Iterator[None]:
    """Import what belongs to ROS in this block.

    Raises:
        RosMissing: something of it is not installed here.

    """
    try:
        use_ros()
        yield
    except (ForeignRos, ImportError) as error:
        raise RosMissing(str(error)) from error


def join_ros(stack: ExitStack) -> None:
    """Join ROS 2 for as long as ``stack`` lasts; signals stay ours."""
    import rclpy
    from rclpy.signals import SignalHandlerOptions

    remove_dead_segments_at_start()
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    stack.callback(rclpy.try_shutdown)
