"""A trial of made message classes, in a process of its own: see `made_types.self_test`.

Also run by a bridge's own Python.
"""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from std_msgs.msg import String

from .made_message_class import forget_error, made_class

if TYPE_CHECKING:
    from typing import Any

__all__ = ["PASSED", "main"]

PASSED = "made classes work"
_TEXT = "talaia"


def main() -> None:
    """Try them, and print `PASSED`."""
    _try_classes()
    sys.stdout.write(f"{PASSED}\n")
    sys.stdout.flush()


def _try_classes() -> None:
    """Publish with a real class and take with a made one; raises if nothing comes."""
    contexts = [Context(), Context()]
    nodes: list[Any] = []
    for context in contexts:
        rclpy.init(context=context)
        name = f"talaia_self_test_{len(nodes)}_{os.getpid()}"
        nodes.append(Node(name, context=context, enable_rosout=False))
    speaker, listener = nodes
    topic = f"/_talaia_self_test_{os.getpid()}"
    publisher = speaker.create_publisher(String, topic, 10)
    kind = made_class("std_msgs/msg/String", "")
    heard: list[bytes] = []
    listener.create_subscription(kind, topic, heard.append, 10, raw=True)
    forget_error()
    executor = SingleThreadedExecutor(context=contexts[1])
    executor.add_node(listener)
    while not heard:
        publisher.publish(String(data=_TEXT))
        executor.spin_once(timeout_sec=0.05)
    if deserialize_message(heard[0], String).data != _TEXT:
        raise RuntimeError("what came is not what was sent")
    executor.shutdown()
    for node in nodes:
        node.destroy_node()
    for context in contexts:
        rclpy.try_shutdown(context=context)
