"""What is to be said to a rosbridge server, until its socket takes it.

Velocities and STOP never wait behind anything else, and of each only the newest is sent. All other
frames go in order. Whoever calls never waits: a server that takes nothing is noticed by its pings.
"""

from __future__ import annotations

import asyncio
from collections import deque
from typing import TYPE_CHECKING

from websockets.exceptions import ConnectionClosed

from talaia.gateway.adapters.rosbridge.protocol import type_for, write_frame

if TYPE_CHECKING:
    from websockets.asyncio.client import ClientConnection

__all__ = ["OutgoingFrames", "ServerTopics"]

_MAX_WAITING = 1000
# What stands last (a zero) is worth this long to a server that may be gone already.
_FLUSH_S = 0.2


class OutgoingFrames:
    """The frames of one connection after the other. On the event loop."""

    def __init__(self) -> None:
        """Start with nothing to say."""
        # By what it is for (`drive base`): the frame whose older ones are worth nothing.
        self._newest: dict[str, str] = {}
        # Frames that go in order.
        self._waiting: deque[str] = deque()
        self._wake = asyncio.Event()

    def replace_newest(self, purpose: str, text: str) -> None:
        """Say something in the place of what was to be said for the same purpose."""
        self._newest[purpose] = text
        self._wake.set()

    def append_frame(self, text: str) -> None:
        """Say something after all that waits, whatever happens."""
        self._waiting.append(text)
        self._wake.set()

    def send_operation(self, op: str, **fields: object) -> None:
        """Ask the server for something."""
        if len(self._waiting) >= _MAX_WAITING:
            # A server that takes nothing for so long is noticed by its pings.
            self._waiting.popleft()
        self.append_frame(write_frame(op, **fields))

    async def write_frames(self, socket: ClientConnection) -> None:
        """Write what there is to say, until cancelled or the connection ends."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            while self._newest or self._waiting:
                # Looked at anew before each ordered frame: driving goes first.
                while self._newest:
                    await socket.send(self._newest.pop(next(iter(self._newest))))
                if self._waiting:
                    await socket.send(self._waiting.popleft())

    async def write_rest(self, socket: ClientConnection) -> None:
        """Write what was said last (a zero), if the server still takes it."""
        for text in (*self._newest.values(), *self._waiting):
            try:
                async with asyncio.timeout(_FLUSH_S):
                    await socket.send(text)
            except (ConnectionClosed, TimeoutError):
                break

    def clear_frames(self) -> None:
        """Forget all: it was for a connection that is gone."""
        self._waiting.clear()
        self._newest.clear()


class ServerTopics:
    """Topics at one server: asked for by the names of types that its ROS uses."""

    def __init__(self, outgoing: OutgoingFrames, ros: int) -> None:
        """Take where requests go, and the version of ROS behind the server."""
        self._outgoing, self._ros = outgoing, ros

    def type_name(self, name: str) -> str:
        """Write a type as the server takes it."""
        return type_for(name, self._ros)

    def advertise_topic(self, topic: str, type_name: str, *, latch: bool = False) -> None:
        """Say that we publish on a topic."""
        kind = self.type_name(type_name)
        self._outgoing.send_operation(
            "advertise", topic=topic, type=kind, latch=latch, queue_size=1
        )

    def subscribe_topic(self, name: str, topic: str, type_name: str, **more: object) -> None:
        """Ask for a topic's messages under a name of ours."""
        self._outgoing.send_operation(
            "subscribe", id=name, topic=topic, type=self.type_name(type_name), **more
        )

    def unsubscribe_topic(self, name: str, topic: str) -> None:
        """Ask for them no more. Others' subscriptions of the topic go on: the name is ours."""
        self._outgoing.send_operation("unsubscribe", topic=topic, id=name)
