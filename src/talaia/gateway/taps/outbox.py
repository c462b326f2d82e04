"""Raw messages on their way to the hub: what waits, in which order, in which pieces."""

from __future__ import annotations

import threading
from collections import deque
from typing import TYPE_CHECKING, NamedTuple, cast

from talaia.gateway.taps.tap_window import TapWindow
from talaia.wire.frames import MEDIA_FROM_GATEWAY, Beat, TapMessage
from talaia.wire.topic_queue import TopicQueue

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.wire.frames import RobotGraph, TapError, TapSchema, TopicList

__all__ = ["TAP_RECEIPTS", "RawTap", "TapOutbox"]

# Receipts of taps count from here; those of pictures, and the connection's own beats, below it.
TAP_RECEIPTS = 2**41
# Bytes that may wait, beside the newest message; and of them of one topic that comes often.
_MOST_WAITING, _SHARE = 32 * 1024 * 1024, 2 * 1024 * 1024
# Of a topic that comes often, what came so long before its newest is left out (µs).
_AGE_US = 500_000
# Messages that are sent at once, a piece of each in turn: a large one holds up no small one.
_MOST_OPEN = 8


class RawTap(NamedTuple):
    """One message, as its topic's entry and the robot have it."""

    number: int
    seq: int
    log_us: int
    publish_us: int
    kept: bool
    data: bytes


class _OpenMessage:
    """A message of which some pieces are sent."""

    def __init__(self, message: RawTap) -> None:
        self.message = message
        self.at = 0
        self._view = memoryview(message.data)

    def next_piece(self, most: int) -> TapMessage:
        """Give the next piece, and count it as sent."""
        message, at = self.message, self.at
        whole = not at and len(message.data) <= most
        # msgspec writes a view as it writes bytes.
        data = message.data if whole else cast("bytes", self._view[at : at + most])
        self.at += len(data)
        return TapMessage(
            number=message.number,
            seq=message.seq,
            log_us=message.log_us,
            publish_us=message.publish_us,
            kept=message.kept,
            size=len(message.data),
            at=at,
            data=data,
        )

    @property
    def done(self) -> bool:
        return self.at >= len(self.message.data)


class TapOutbox:
    """What waits for the connection for pictures. Messages and notices come from any thread."""

    def __init__(self, clock: Clock) -> None:
        """Begin without a connection."""
        self._clock = clock
        # Called, from any thread, when something waits and nothing did.
        self.on_waiting: Callable[[], None] = lambda: None
        # Called on the loop when a connection has begun.
        self.on_linked: Callable[[], None] = lambda: None
        self._lock = threading.Lock()
        self._linked = False
        self._queue: TopicQueue[RawTap] = TopicQueue(
            share=_SHARE, most=_MOST_WAITING, age_us=_AGE_US
        )
        # Lists, schemas and errors, before all messages.
        self._notices: deque[bytes] = deque()
        # In the order of their turns.
        self._open: deque[_OpenMessage] = deque()
        self._window = TapWindow()
        # A receipt that is to be asked for behind the piece that was sent last.
        self._receipt: int | None = None
        # Whoever waits has been told.
        self._told = False

    @property
    def dropped(self) -> int:
        """How many messages were left out because the line was slower than they came."""
        return self._queue.dropped

    # ── any thread ──

    def enqueue_notice(self, notice: TopicList | TapSchema | TapError | RobotGraph) -> None:
        """Queue what comes before all messages that are queued after it."""
        data = MEDIA_FROM_GATEWAY.encode(notice)
        with self._lock:
            if self._linked:
                self._notices.append(data)
                self._tell_waiting()

    def enqueue_message(self, message: RawTap) -> None:
        """Queue a message, in place of older ones of its topic where there are too many."""
        now_us = self._clock.monotonic_ns() // 1000
        with self._lock:
            if self._linked:
                size = len(message.data)
                self._queue.add(message.number, message, size, now_us=now_us, kept=message.kept)
                self._tell_waiting()

    def forget_topic(self, number: int) -> None:
        """Forget what waits of a topic that nobody wants any more."""
        with self._lock:
            self._queue.remove_topic(number)
            self._open = deque(one for one in self._open if one.message.number != number)

    def _tell_waiting(self) -> None:
        if not self._told:
            self._told = True
            self.on_waiting()

    # ── on the loop ──

    def next_frame(self) -> bytes | None:
        """Give the next frame to send; None while nothing waits or the line has no room."""
        with self._lock:
            frame = self._next_frame()
            if frame is None:
                self._told = False
            return frame

    def _next_frame(self) -> bytes | None:
        if self._notices:
            return self._notices.popleft()
        now_us = self._clock.monotonic_ns() // 1000
        if self._receipt is not None:
            number, self._receipt = self._receipt, None
            return MEDIA_FROM_GATEWAY.encode(Beat(n=TAP_RECEIPTS + number, mono_us=now_us))
        if not (self._open or self._queue) or not self._window.has_room():
            return None
        self._begin_next()
        opened = self._open.popleft()
        frame = MEDIA_FROM_GATEWAY.encode(opened.next_piece(self._window.piece()))
        if not opened.done:
            self._open.append(opened)
        self._receipt = self._window.sent(len(frame), now_us)
        return frame

    def _begin_next(self) -> None:
        """Let another message begin, before the next pieces of those that are under way."""
        if len(self._open) < _MOST_OPEN:
            found = self._queue.next_message(skip={one.message.number for one in self._open})
            if found is not None:
                self._open.appendleft(_OpenMessage(found[1]))

    def take_receipt(self, number: int) -> None:
        """Take the answer to a beat with the number ``TAP_RECEIPTS`` and more."""
        with self._lock:
            self._window.arrived(number - TAP_RECEIPTS, self._clock.monotonic_ns() // 1000)
            if self._open or self._queue:
                self._tell_waiting()

    def link_up(self) -> None:
        """Begin with nothing old, on a connection that nobody knows."""
        with self._lock:
            self._clear()
            self._linked = True
        self.on_linked()

    def link_lost(self) -> None:
        """Take no more until the next connection."""
        with self._lock:
            self._clear()
            self._linked = False

    def _clear(self) -> None:
        self._queue.clear()
        self._notices.clear()
        self._open.clear()
        self._window.clear()
        self._receipt = None
        self._told = False
