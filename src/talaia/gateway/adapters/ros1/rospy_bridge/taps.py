"""Raw topics for the hub: subscribed only while somebody wants them, and what waits is bounded."""

# ruff: noqa: ANN401 - rospy ships no types
from __future__ import annotations

import queue
import threading
import time
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

import rospy

from .pipe_frames import MAX_FRAME, PIECE, TAPPED
from .topics import serialized_bytes

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from .pipe_frames import FrameWriter

# A larger message is left out; no hub takes it (bytes).
MAX_TAPPED = 32 * 1024 * 1024
# Bytes that may wait for the pipe beside the newest message; and of them of one topic.
_MOST_WAITING, _SHARE = 32 * 1024 * 1024, 4 * 1024 * 1024
# A message goes in pieces (bytes), so that signals pass between them.
_PIECE = 64 * 1024
# Messages that rospy keeps of those that it reads at once.
_DEPTH = 1_000
# Publishers of one topic that differ in type, definition or latching; more are nonsense.
_MOST_KINDS = 100


class _Message(NamedTuple):
    kind: int
    at_us: int
    raw: bytes
    latched: bool


class TapLines:
    """Messages on their way to the gateway, by topic; written by a thread of its own."""

    def __init__(self, out: FrameWriter) -> None:
        """Take where they go."""
        self._out = out
        self._wake = threading.Condition()
        # By tap, in the order of their turns; the oldest first.
        self._waiting: dict[int, deque[_Message]] = {}
        self._bytes: dict[int, int] = {}
        # A tap whose message is being written, as long as it is wanted.
        self._writing = 0

    def add_message(self, tap: int, message: _Message) -> None:
        """Queue a message; older ones give way where there are too many, those of latched last."""
        size = len(message.raw)
        with self._wake:
            line = self._waiting.setdefault(tap, deque())
            line.append(message)
            self._bytes[tap] = self._bytes.get(tap, 0) + size
            while len(line) > 1 and self._bytes[tap] > _SHARE and not line[0].latched:
                self._drop_oldest(tap)
            # Beside the newest, so that a large one pushes nothing out.
            while sum(self._bytes.values()) - size > _MOST_WAITING:
                self._drop_oldest(self._largest_but(tap))
            self._wake.notify()

    def forget_tap(self, tap: int) -> None:
        """Forget what waits of a topic that nobody wants any more."""
        with self._wake:
            self._waiting.pop(tap, None)
            self._bytes.pop(tap, None)
            if self._writing == tap:
                self._writing = 0

    def write_messages(self) -> None:
        """Write what waits, a message of each topic in turn. On a thread of its own."""
        while True:
            with self._wake:
                while not self._waiting:
                    self._wake.wait()
                tap = self._writing = next(iter(self._waiting))
                line = self._waiting.pop(tap)
                message = line.popleft()
                self._bytes[tap] -= len(message.raw)
                if line:
                    # Its next turn comes behind all others.
                    self._waiting[tap] = line
                else:
                    del self._bytes[tap]
            self._write_pieces(tap, message)

    def _write_pieces(self, tap: int, message: _Message) -> None:
        raw, size = memoryview(message.raw), len(message.raw)
        # An empty message is one piece, too.
        for at in range(0, max(1, size), _PIECE):
            if self._writing != tap:
                return
            head = PIECE.pack(tap, message.kind, message.at_us, size, at)
            self._out.write_frame(TAPPED, head + raw[at : at + _PIECE])

    def _drop_oldest(self, tap: int) -> None:
        self._bytes[tap] -= len(self._waiting[tap].popleft().raw)
        if not self._waiting[tap]:
            del self._waiting[tap], self._bytes[tap]

    def _largest_but(self, tap: int) -> int:
        """Give the tap of which most waits, beside the newest message of this one."""
        others = {one: size for one, size in self._bytes.items() if one != tap}
        if len(self._waiting[tap]) > 1:
            others[tap] = self._bytes[tap] - len(self._waiting[tap][-1].raw)
        return max(others, key=others.__getitem__)


class TapRunner:
    """All taps of one node, by the gateway's numbers.

    They begin and end on a thread of their own: each is a question to the master, and driving does
    not wait behind hundreds of them.
    """

    def __init__(self, out: FrameWriter, read_elsewhere: Callable[[str], bool]) -> None:
        """Take where messages go, and who knows which topics this node hears anyway."""
        self._out = out
        self._read_elsewhere = read_elsewhere
        self._lines = TapLines(out)
        self._taps: dict[int, TappedSubscription] = {}
        self._orders: queue.Queue[dict[str, Any]] = queue.Queue()

    def start_threads(self) -> None:
        """Begin to do as told."""
        for work in (self._obey, self._lines.write_messages):
            threading.Thread(target=work, daemon=True).start()

    def order_tap(self, asked: dict[str, Any]) -> None:
        """Begin or end a tap soon."""
        self._orders.put(asked)

    def _obey(self) -> None:
        while True:
            asked = self._orders.get()
            try:
                self._begin_or_end(asked)
            except Exception as error:  # noqa: BLE001 - rospy names none; the others must go on
                self._out.send_frame(op="tap_problem", tap=asked["tap"], problem=str(error)[:500])

    def _begin_or_end(self, asked: dict[str, Any]) -> None:
        number = asked["tap"]
        if asked["op"] == "tap":
            self._taps[number] = TappedSubscription(
                out=self._out,
                lines=self._lines,
                number=number,
                name=asked["name"],
                shared=self._read_elsewhere(asked["name"]),
            )
        elif number in self._taps:
            self._taps.pop(number).close()
            self._lines.forget_tap(number)


class TappedSubscription:
    """A subscription whose messages go on as they are; before the first of a kind its type goes."""

    def __init__(
        self, *, out: FrameWriter, lines: TapLines, number: int, name: str, shared: bool
    ) -> None:
        """Subscribe; ``shared``: this node has subscribed the topic already, in its own way."""
        self._out, self._lines, self._number = out, lines, number
        # By type, definition and latching of a publisher: its number. rospy has a thread for each.
        self._kinds: dict[tuple[str, str, bool], int] = {}
        self._turn = threading.Lock()
        self._subscriber = rospy.Subscriber(
            name,
            rospy.AnyMsg,
            self._forward_message,
            # rospy has one queue for all of a node's subscriptions of a topic.
            queue_size=None if shared else _DEPTH,
            # See `RawSubscription`.
            buff_size=MAX_FRAME,
            tcp_nodelay=True,
        )

    def close(self) -> None:
        """Unsubscribe."""
        self._subscriber.unregister()

    def _forward_message(self, message: Any) -> None:
        at_us = time.time_ns() // 1000
        header = message._connection_header  # noqa: SLF001 - rospy has no other way
        raw = serialized_bytes(message)
        latched = header.get("latching", "0") == "1"
        key = header.get("type", ""), header.get("md5sum", ""), latched
        kind = self._kinds.get(key)
        if kind is None:
            kind = self._report_kind(key, header.get("message_definition", ""))
        if len(raw) > MAX_TAPPED:
            problem = f"a message of {len(raw)} bytes is too large to be handed on"
            self._out.send_frame(op="tap_problem", tap=self._number, problem=problem)
        elif kind <= _MOST_KINDS:
            self._lines.add_message(self._number, _Message(kind, at_us, raw, latched))

    def _report_kind(self, key: tuple[str, str, bool], definition: str) -> int:
        with self._turn:
            known = self._kinds.get(key)
            if known is not None:
                return known
            kind = len(self._kinds) + 1
            if kind <= _MOST_KINDS:
                type_name, md5, latched = key
                self._out.send_frame(
                    op="tapped_kind",
                    tap=self._number,
                    kind=kind,
                    type=type_name,
                    md5=md5,
                    definition=definition,
                    latched=latched,
                )
                # Only now: what other threads queue of it comes behind.
                self._kinds[key] = kind
            return kind
