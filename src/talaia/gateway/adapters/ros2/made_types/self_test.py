"""Tries made message classes in a process of its own, before any is used in the gateway's.

A class whose C structs do not fit this ROS ends its process, or hangs it so that SIGTERM is not
heard. The child publishes a text with its real class and takes it by a made one, in a domain that
robots do not use; whatever it does, it is ended with SIGKILL.
"""

from __future__ import annotations

import os
import select
import subprocess
import sys
import threading
import time

from talaia.ros_installation import use_ros

__all__ = ["self_test_problem"]

# The highest domains have ports that nothing else on a Linux machine is given.
_DOMAIN = 231
_PATIENCE_S = 20.0
_PASSED = "made classes work"
_TEXT = "talaia"
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
    environment = {
        **os.environ,
        "ROS_DOMAIN_ID": str(_DOMAIN),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    }
    # Robots elsewhere must not be met.
    environment.pop("ROS_STATIC_PEERS", None)
    with subprocess.Popen(  # noqa: S603 - this module, by this Python
        [sys.executable, "-m", __name__],
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


def _try_classes() -> None:
    """Publish with a real class and take with a made one; raises if nothing comes."""
    import rclpy
    from rclpy.context import Context
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.node import Node
    from rclpy.serialization import deserialize_message
    from std_msgs.msg import String

    from talaia.gateway.adapters.ros2.made_types.made_message_class import forget_error, made_class

    contexts = [Context(), Context()]
    nodes: list[Node] = []
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
    for node, context in zip(nodes, contexts, strict=True):
        node.destroy_node()
        rclpy.try_shutdown(context=context)


if __name__ == "__main__":
    use_ros()
    _try_classes()
    sys.stdout.write(f"{_PASSED}\n")
    sys.stdout.flush()
