"""How ROS 2 is joined: a node that hears and speaks, and offers nothing of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import rclpy
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["join_graph", "pacer_of", "wait_sets_of"]


def join_graph(name: str, context: Any, domain: int | None) -> Any:  # noqa: ANN401 - rclpy ships no types
    """Begin a context and give its node.

    Args:
        name: the node's.
        context: rclpy's, not begun; its end is the caller's.
        domain: its number; none takes the environment's.

    """
    rclpy.init(
        args=["--ros-args", "--disable-rosout-logs", "--disable-external-lib-logs"],
        context=context,
        domain_id=domain,
        # Whoever joins ends its parts in an order of its own.
        signal_handler_options=SignalHandlerOptions.NO,
    )
    # Nothing spins this node, so it offers no services that nobody would answer.
    quiet = Parameter("start_type_description_service", value=False)
    return Node(
        name,
        context=context,
        use_global_arguments=False,
        enable_rosout=False,
        start_parameter_services=False,
        parameter_overrides=[quiet],
    )


def wait_sets_of(context: Any) -> Callable[[int, int], Any]:  # noqa: ANN401
    """Give what makes a wait set for so many subscriptions and clients, and one guard."""

    def make(subscriptions: int, clients: int) -> Any:  # noqa: ANN401
        return rclpy_implementation.WaitSet(subscriptions, 1, 0, clients, 0, 0, context.handle)

    return make


def pacer_of(context: Any) -> Callable[[float], None] | None:  # noqa: ANN401
    """Give what is told how long turns are (s), where another process takes the messages."""
    # rclpy's own context has none: there nobody is between the robot and the wait set.
    return getattr(context, "shorten_turns", None)
