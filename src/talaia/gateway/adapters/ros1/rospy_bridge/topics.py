"""Subscriptions by raw bytes, and publications that end with a zero."""

# ruff: noqa: ANN401 - rospy ships no types
from __future__ import annotations

import io
import threading
import time
from typing import TYPE_CHECKING

import rospy

from .message_paths import class_of, fill_message, message_class
from .pipe_frames import MAX_FRAME, MESSAGE, STAMP

if TYPE_CHECKING:
    from typing import Any

    from .pipe_frames import FrameWriter


def serialized_bytes(message: Any) -> bytes:
    """Give a message as it came.

    rospy gives all of a node's subscriptions of a topic the class of the first: who comes behind an
    action's client, or behind rospy's own subscription of ``/clock``, gets messages that are read.
    """
    if isinstance(message, rospy.AnyMsg):
        return message._buff  # type: ignore[no-any-return]  # noqa: SLF001 - rospy has no other way
    into = io.BytesIO()
    message.serialize(into)
    return into.getvalue()


class RawSubscription:
    """A subscription by raw bytes, so that a type need not be known here.

    Before the first message of a type goes out, the type has: the gateway decodes by it.

    Attributes:
        name: its absolute name.

    """

    def __init__(self, *, out: FrameWriter, number: int, name: str, rate: float, deep: int) -> None:
        """Subscribe; with ``rate`` (Hz) messages that come sooner are left."""
        self._out = out
        self._number, self._name = number, name
        self.name = rospy.resolve_name(name)
        self._period = 1.0 / rate if rate else 0.0
        # When the next one may go out (monotonic, s).
        self._due = 0.0
        # MD5 of the type that was told last, and what was told of latching with it.
        self._known = ""
        self._latchings: set[bool] = set()
        self._subscriber = rospy.Subscriber(
            name,
            rospy.AnyMsg,
            self._forward_message,
            queue_size=deep,
            # A queue of one drops old messages only among those read at once; with rospy's default
            # of 64 KiB old pictures pile up in the socket (see rospy.Subscriber, buff_size).
            buff_size=MAX_FRAME,
            tcp_nodelay=True,
        )

    def _forward_message(self, message: Any) -> None:
        at_us = time.time_ns() // 1000
        if self._period:
            now = time.monotonic()
            if now < self._due:
                return
            # From when it was due, not from now: else the rate would come out too low.
            self._due = max(self._due + self._period, now)
        header = message._connection_header  # noqa: SLF001 - rospy has no other way
        known = header.get("md5sum", "")
        # A publisher may come back with another definition, or another one be latched or not.
        latched = header.get("latching", "0") == "1"
        if known != self._known or latched not in self._latchings:
            self._latchings = {latched} | (self._latchings if known == self._known else set())
            self._known = known
            self._out.send_frame(
                op="type",
                topic=self._number,
                type=header.get("type", ""),
                md5=known,
                definition=header.get("message_definition", ""),
                latched=latched,
            )
        raw = serialized_bytes(message)
        if len(raw) + STAMP.size < MAX_FRAME:
            self._out.write_frame(MESSAGE, STAMP.pack(self._number, at_us) + raw)
        else:
            problem = f"a message of {len(raw)} bytes is too large, and is left out"
            self._out.send_frame(op="complaint", id=self._name, problem=problem)

    def close(self) -> None:
        """Unsubscribe."""
        self._subscriber.unregister()


class ZeroEndedPublisher:
    """A publication, and the zero that ends what it says.

    Where it has a zero, nothing else stands longer than the silence that `end_silence` is told.
    """

    def __init__(self, asked: dict[str, Any]) -> None:
        """Advertise."""
        kind = class_of(asked["type"], message_class)
        self._kind = kind
        self._zero: dict[str, Any] | None = asked.get("zero")
        # Fields that the zero leaves as they were said last: steered wheels stay as they stand.
        self._kept: list[str] = asked.get("kept", [])
        # Whether something other than the zero was said last, and when (monotonic, s).
        self._moving = False
        self._said = 0.0
        # The gateway's frames and the watching thread both publish; a zero that overtakes a newer
        # velocity, or comes behind one that was meant to follow, must not be.
        self._turn = threading.Lock()
        self.publisher = rospy.Publisher(
            asked["topic"],
            kind,
            queue_size=asked.get("deep", 1),
            latch=asked.get("latch", False),
            tcp_nodelay=True,
        )

    def publish_fields(self, fields: dict[str, Any]) -> None:
        """Publish a message with these fields."""
        message = fill_message(self._kind(), fields)
        with self._turn:
            if self._zero is not None:
                self._zero |= {path: fields[path] for path in self._kept}
            self._moving = self._zero is not None and fields != self._zero
            self._said = time.monotonic()
            self.publisher.publish(message)

    def end_silence(self, silence: float) -> None:
        """Say zero if something else stands and is older than this (s)."""
        with self._turn:
            if self._zero is not None and self._moving and time.monotonic() - self._said >= silence:
                self._moving = False
                self.publisher.publish(fill_message(self._kind(), self._zero))
