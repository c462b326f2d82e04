"""What was said once and still holds (maps, static transforms, models): bounded, for recordings."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from talaia.gateway.recording.message_ring import OVERHEAD
from talaia.model.topics import is_latched_by_convention

if TYPE_CHECKING:
    from talaia.gateway.recording.message_ring import RawMessage

__all__ = ["StandingMessages"]

# Of one topic: several nodes say a part each of static transforms, one says a whole map.
_PARTS, _MOST_PARTS = ("tf_static",), 50


class StandingMessages:
    """The last messages of topics that are latched by convention."""

    def __init__(self, max_bytes: int) -> None:
        """Hold so many bytes; what is more than there is room for is not held."""
        self._max_bytes = max_bytes
        self._held: dict[str, deque[RawMessage]] = {}
        self._bytes = 0

    def remember_message(self, raw: RawMessage) -> None:
        """Hold a message, if it is of such a topic, in the place of what it replaces."""
        if not is_latched_by_convention(raw.topic, raw.type_name):
            return
        most = _MOST_PARTS if raw.topic.rsplit("/", 1)[-1] in _PARTS else 1
        held = self._held.setdefault(raw.topic, deque())
        while len(held) >= most:
            self._bytes -= len(held.popleft().data) + OVERHEAD
        if self._bytes + len(raw.data) + OVERHEAD <= self._max_bytes:
            held.append(raw)
            self._bytes += len(raw.data) + OVERHEAD

    def messages_before(self, mono_ns: int, time_ns: int) -> list[RawMessage]:
        """Give what was said before a moment, put to that moment.

        Args:
            mono_ns: the moment, by the monotonic clock.
            time_ns: the same by the wall clock; when each was said stays in its ``said_ns``.

        """
        return [
            raw._replace(time_ns=time_ns, mono_ns=mono_ns, said_ns=raw.time_ns)
            for held in self._held.values()
            for raw in held
            if raw.mono_ns < mono_ns
        ]
