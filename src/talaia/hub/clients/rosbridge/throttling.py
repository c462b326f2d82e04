"""What waits for a client's own throttle: bounded, in order, no topic before its time. Pure."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Generic, NamedTuple, TypeVar

from talaia.clock import MS

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["TopicThrottles"]

_Item = TypeVar("_Item")

# Messages of one topic that wait, however long a queue the client asks for.
_MOST_QUEUED = 100


class _Throttle(NamedTuple):
    """One topic's."""

    interval_ns: int
    queue: int


class TopicThrottles(Generic[_Item]):
    """The throttles of one client, by topic; times are monotonic."""

    def __init__(self, most_bytes: int) -> None:
        """Hold at most ``most_bytes`` of all topics beside the newest message of each."""
        self._most = most_bytes
        self._bytes = 0
        self._throttles: dict[str, _Throttle] = {}
        # By topic: when its next message may go.
        self._next_ns: dict[str, int] = {}
        # By topic: what waits, each with its bytes; never empty.
        self._waiting: dict[str, deque[tuple[_Item, int]]] = {}

    @property
    def waiting_bytes(self) -> int:
        """How many bytes wait."""
        return self._bytes

    def set_throttle(self, topic: str, *, interval_ms: float, queue: float) -> None:
        """Keep ``interval_ms`` between messages of a topic; up to ``queue`` wait meanwhile.

        Of a topic without a queue the newest waits, so that a client is never left with less than
        what is true now.
        """
        interval_ns = round(max(0.0, interval_ms) * MS)
        queued = int(min(max(1, queue), _MOST_QUEUED))
        self._throttles[topic] = _Throttle(interval_ns, queued)

    def forget_topic(self, topic: str) -> None:
        """Forget a topic and what waits of it."""
        self._throttles.pop(topic, None)
        self._next_ns.pop(topic, None)
        for _, size in self._waiting.pop(topic, ()):
            self._bytes -= size

    def admit_message(self, topic: str, item: _Item, size: int, now_ns: int) -> bool:
        """Tell whether a message may go now; if not, it waits as long as there is room."""
        throttle = self._throttles.get(topic)
        if throttle is None or not throttle.interval_ns:
            return True
        waiting = self._waiting.get(topic)
        if not waiting and now_ns >= self._next_ns.get(topic, now_ns):
            self._next_ns[topic] = now_ns + throttle.interval_ns
            return True
        waiting = self._waiting.setdefault(topic, deque())
        waiting.append((item, size))
        self._bytes += size
        while len(waiting) > throttle.queue or (len(waiting) > 1 and self._bytes > self._most):
            self._bytes -= waiting.popleft()[1]
        return False

    def due_ns(self) -> int | None:
        """Give when `pop_due` has something next, or none."""
        return min((self._next_ns[topic] for topic in self._waiting), default=None)

    def pop_due(self, now_ns: int) -> Iterator[tuple[str, _Item]]:
        """Give what may go now, at most one message of each topic."""
        for topic in [topic for topic in self._waiting if self._next_ns[topic] <= now_ns]:
            waiting = self._waiting[topic]
            item, size = waiting.popleft()
            self._bytes -= size
            if not waiting:
                del self._waiting[topic]
            throttle = self._throttles.get(topic)
            self._next_ns[topic] = now_ns + (throttle.interval_ns if throttle else 0)
            yield topic, item
