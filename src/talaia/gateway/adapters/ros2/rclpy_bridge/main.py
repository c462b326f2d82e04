"""Joins ROS 2 and does as the gateway says, until stdin ends.

Frames go over stdin and stdout (`pipe_frames`); what ROS prints goes to stderr. When stdin ends, or
says nothing for long while a velocity stands, zeros are published (`velocities`).
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from typing import TYPE_CHECKING

import rclpy

from .descriptions import class_named, describe_type, interface_packages
from .nodes import JoinedNode
from .pipe_frames import (
    CALL,
    JSON,
    NUMBERED_HEAD,
    PUBLISH,
    PipeWriter,
    json_frame,
    read_frames,
)

if TYPE_CHECKING:
    from typing import Any

_WATCH_EVERY_S = 0.05


class Bridge:
    """All that one gateway has joined. Frames are handled one after the other, on one thread."""

    def __init__(self, out: PipeWriter) -> None:
        """Join nothing yet."""
        self._out = out
        # By the gateway's number. Also read by the watching thread.
        self._nodes: dict[int, JoinedNode] = {}
        # Which node has an entity.
        self._owners: dict[int, JoinedNode] = {}
        self._ended = threading.Event()
        self._parent = os.getppid()

    def handle(self, kind: int, body: bytes) -> None:
        """Act on one frame."""
        if kind == JSON:
            self._answer(json.loads(body.decode()))
            return
        number, value = NUMBERED_HEAD.unpack_from(body)
        # What was destroyed a moment ago may still be spoken to.
        owner = self._owners.get(number)
        if owner is None:
            return
        if kind == PUBLISH:
            owner.publish(number, body[NUMBERED_HEAD.size :], value)
        elif kind == CALL:
            owner.call(number, body[NUMBERED_HEAD.size :], value)

    def watch(self) -> None:
        """End velocities that nobody renews. On a thread of its own."""
        while not self._ended.wait(_WATCH_EVERY_S):
            # Another process that has the gateway's pipe may outlive it.
            if os.getppid() != self._parent:
                self.abandon(ConnectionError("the gateway is gone"))
            for node in list(self._nodes.values()):
                node.end_silence()

    def publish_zeros(self) -> None:
        """Publish the zeros, for nobody drives any more."""
        self._ended.set()
        for _ in range(3):
            for node in list(self._nodes.values()):
                node.end_silence(0.0)
            # The middleware sends on threads of its own.
            time.sleep(0.03)

    def abandon(self, error: BaseException) -> None:
        """End this process: it hears nothing any more, or nobody hears it. Any thread."""
        print(f"{type(error).__name__}: {error}", file=sys.stderr, flush=True)  # noqa: T201
        self.publish_zeros()
        os._exit(1)

    def leave_all(self) -> None:
        """Leave every domain."""
        for number in list(self._nodes):
            self.do_leave(number)

    # ── questions ──

    def _answer(self, asked: dict[str, Any]) -> None:
        call, words = asked.pop("call"), asked.pop("do")
        try:
            result = getattr(self, f"do_{words}")(**asked)
            said: dict[str, Any] = {"call": call, "result": result}
        # rclpy raises bare kinds for what it refuses.
        except Exception as error:  # noqa: BLE001 - the gateway decides what it means
            said = {"call": call, "error": str(error) or type(error).__name__}
        self._out.write(json_frame(said))

    def do_describe(self, name: str) -> Any:  # noqa: ANN401
        """Describe a message type; None for one that is not installed."""
        return describe_type(name)

    def do_knows(self, name: str) -> bool:
        """Tell whether a type is installed."""
        return class_named(name) is not None

    def do_join(self, node: int, name: str, domain: int | None) -> int:
        """Join a domain with a node; give the domain's number."""
        joined = JoinedNode(name, domain, self._out, self.abandon)
        self._nodes[node] = joined
        return int(joined.domain)

    def do_leave(self, node: int) -> None:
        """Leave it."""
        joined = self._nodes.pop(node, None)
        if joined is not None:
            self._owners = {key: who for key, who in self._owners.items() if who is not joined}
            joined.close()

    def do_pace(self, node: int, pace_s: float) -> None:
        """Take so often (s) what came."""
        self._nodes[node].shorten_turns(pace_s)

    def do_make(self, node: int, entity: int, what: str, **more: Any) -> None:  # noqa: ANN401
        """Make a subscription, a publisher or a client."""
        joined = self._nodes[node]
        joined.make(what, entity, **more)
        self._owners[entity] = joined

    def do_destroy(self, entity: int) -> None:
        """End one of these."""
        owner = self._owners.pop(entity, None)
        if owner is not None:
            owner.destroy(entity)

    def do_guard(self, entity: int, zero: str, begin: int, end: int) -> None:
        """End with this what a publisher publishes."""
        self._owners[entity].guard(entity, bytes.fromhex(zero), (begin, end))

    def do_ready(self, entity: int) -> bool:
        """Tell whether anybody offers a client's service."""
        owner = self._owners.get(entity)
        return owner is not None and owner.is_ready(entity)

    def do_listeners(self, entity: int) -> int:
        """Count who listens to a publisher."""
        owner = self._owners.get(entity)
        return 0 if owner is None else owner.count_listeners(entity)

    def do_graph(self, node: int, question: str, words: list[Any]) -> Any:  # noqa: ANN401
        """Ask the graph."""
        return self._nodes[node].ask_graph(question, words)


def main() -> None:
    """Serve until stdin ends."""
    out = PipeWriter(os.dup(1))
    # Whatever prints must not spoil the frames.
    os.dup2(2, 1)
    bridge = Bridge(out)
    hello = {
        "hello": 1,
        "packages": interface_packages(),
        # Its setup.bash may have been read for this process alone.
        "distribution": os.environ.get("ROS_DISTRO", ""),
        "rmw": rclpy.get_rmw_implementation_identifier(),
        "python": ".".join(map(str, sys.version_info[:2])),
        "where": os.path.dirname(os.path.dirname(rclpy.__file__)),
    }
    # The gateway waits for this: from here on rclpy is there.
    out.write(json_frame(hello))
    # The main thread may wait for ROS or for a full pipe; zeros must not.
    threading.Thread(target=bridge.watch, daemon=True).start()
    try:
        for kind, body in read_frames(os.fdopen(0, "rb")):
            bridge.handle(kind, body)
    finally:
        # What hangs in ROS must not keep this process.
        timer = threading.Timer(3.0, lambda: os._exit(0))
        timer.daemon = True
        timer.start()
        bridge.publish_zeros()
        bridge.leave_all()
        os._exit(0)
