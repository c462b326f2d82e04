"""The last seconds of raw messages, in memory. Pure, and bounded in time and in bytes."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

__all__ = ["MessageRing", "RawMessage"]

# What a message takes in memory beside its bytes, about.
OVERHEAD = 200


class RawMessage(NamedTuple):
    """A message as it came.

    Attributes:
        time_ns: when it came (wall, UTC).
        mono_ns: the same by the monotonic clock, which decides how long it is held.
        definition: of its type; empty for ROS 2 where its package is installed here.
        encoding: of its bytes: ``cdr`` or ``ros1``.
        said_ns: when it came, where it stands at a later moment because it still holds (wall,
            UTC); 0: ``time_ns`` says it.

    """

    topic: str
    type_name: str
    time_ns: int
    mono_ns: int
    data: bytes
    definition: str = ""
    encoding: str = "cdr"
    said_ns: int = 0


class MessageRing:
    """Holds messages until they are too old or too many bytes."""

    def __init__(self, keep_ns: int, max_bytes: int) -> None:
        """Start empty."""
        self._keep_ns = keep_ns
        self._max_bytes = max_bytes
        self._held: deque[RawMessage] = deque()
        self.bytes = 0

    def __len__(self) -> int:
        """Count the messages."""
        return len(self._held)

    def add_message(self, raw: RawMessage) -> None:
        """Take the newest message; what is over a bound goes, the oldest first."""
        self._held.append(raw)
        self.bytes += len(raw.data) + OVERHEAD
        self.trim_old(raw.mono_ns)

    def trim_old(self, now_ns: int) -> None:
        """Let go of what is too old, or too much."""
        held = self._held
        while held and (self.bytes > self._max_bytes or now_ns - held[0].mono_ns > self._keep_ns):
            self.bytes -= len(held.popleft().data) + OVERHEAD

    def drain_messages(self) -> deque[RawMessage]:
        """Give all that is held, in order, and hold nothing; as quick for much as for little."""
        taken, self._held, self.bytes = self._held, deque(), 0
        return taken
