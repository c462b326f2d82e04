"""``talaia sim``: a simulated robot, which also hears types whose package is not installed."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from talaia.sim.run import main as run_robot, parse_words

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rclpy.node import Node

__all__ = ["listen_by_name", "main", "parse_words"]

log = logging.getLogger(__name__)
# Of what moves a robot only the newest counts.
_NEWEST = 1


def main(argv: Sequence[str]) -> int:
    """Run the robot that is named; see `talaia.sim.run`."""
    return run_robot(argv, listen_by_name)


def listen_by_name(
    node: Node, topic: str, kind: tuple[str, str], hear: Callable[[bytes], None]
) -> bool:
    """See `RawListening`."""
    # Once ROS is there, and only for a robot that asks.
    from talaia.gateway.adapters.ros2.made_types.made_message_class import (
        CannotMakeTypes,
        forget_error,
        made_class,
        problem_here,
    )
    from talaia.gateway.adapters.ros2.made_types.self_test import self_test_problem

    made, problem = None, problem_here() or self_test_problem()
    try:
        made = None if problem else made_class(*kind)
    except CannotMakeTypes as error:
        problem = str(error)
    if made is None:
        log.warning("%s is not listened to: %s", topic, problem)
        return False
    node.create_subscription(made, topic, hear, _NEWEST, raw=True)
    forget_error()
    return True
