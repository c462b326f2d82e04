"""Messages of several topics that wait for one line: bounded, and the newest count. Pure.

Both ends of a tap have it: the gateway before the line to its hub, the hub before the line of each
taker. A topic that comes often gives up its oldest messages when the line is slower than it; one
that is latched, or comes seldom, is never thinned, for each of its messages says something.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Generic, NamedTuple, TypeVar

if TYPE_CHECKING:
    from collections.abc import Container, Hashable

__all__ = ["ArrivalMeter", "RateGate", "TopicQueue"]

Item = TypeVar("Item")

# A topic comes seldom while no more than so many messages came within so long (µs): below 5 Hz.
_FEW, _WINDOW_US = 10, 2_000_000
# A message that comes this much (of a period) too early still counts as on time: publishers jitter.
_EARLY = 0.1


class ArrivalMeter:
    """Tells whether a topic comes seldom."""

    def __init__(self) -> None:
        """Begin with a topic that has not come yet."""
        # When its last ones came (µs).
        self._times: deque[int] = deque(maxlen=_FEW)

    def count_arrival(self, now_us: int) -> bool:
        """Count a message; give whether its topic comes seldom."""
        often = len(self._times) == _FEW and now_us - self._times[0] < _WINDOW_US
        self._times.append(now_us)
        return not often


class RateGate:
    """Lets at most so many a second through, evenly."""

    def __init__(self, max_rate: float) -> None:
        """Take the rate (Hz); 0 lets all through."""
        # Between two of them (µs).
        self._period_us = 1e6 / max_rate if max_rate else 0.0
        # When the next one may pass (µs).
        self._due_us = 0.0

    def passes(self, now_us: int) -> bool:
        """Tell whether a message that comes now goes on; then it counts."""
        if now_us < self._due_us - _EARLY * self._period_us:
            return False
        # From when it was due, not from now: else the rate would come out too low.
        # Silence is not made up for.
        begin_us = self._due_us if now_us - self._due_us < self._period_us else now_us
        self._due_us = begin_us + self._period_us
        return True


class _WaitingMessage(NamedTuple, Generic[Item]):
    item: Item
    size: int
    # When it came (µs).
    at_us: int
    # It is not to be thinned out.
    kept: bool


class _TopicLine(Generic[Item]):
    """What waits of one topic, the oldest first."""

    def __init__(self) -> None:
        self.waiting: deque[_WaitingMessage[Item]] = deque()
        self.bytes = 0

    def pop_oldest(self) -> _WaitingMessage[Item]:
        oldest = self.waiting.popleft()
        self.bytes -= oldest.size
        return oldest


class TopicQueue(Generic[Item]):
    """See the module. Not for several threads at once.

    Attributes:
        bytes: that wait.
        dropped: messages that were left out.

    """

    def __init__(self, *, share: int, most: int, age_us: int) -> None:
        """Hold at most so much.

        Args:
            share: bytes of a topic that comes often; its newest message is held whatever its size.
            most: bytes of all topics together, beside the newest message; above it the oldest of
                the largest topic goes, whatever it is.
            age_us: of a topic that comes often, what came so long before its newest is left out.

        """
        self._share, self._most, self._age_us = share, most, age_us
        # In the order of their turns.
        self._lines: dict[Hashable, _TopicLine[Item]] = {}
        self.bytes = 0
        self.dropped = 0

    def __bool__(self) -> bool:
        """Tell whether anything waits."""
        return bool(self._lines)

    def add(self, topic: Hashable, item: Item, size: int, *, now_us: int, kept: bool) -> None:
        """Take a message in.

        Args:
            topic: whose it is.
            item: itself.
            size: its bytes.
            now_us: when it comes; of any clock that goes steadily.
            kept: its topic is not to be thinned.

        """
        line = self._lines.get(topic)
        if line is None:
            line = self._lines[topic] = _TopicLine()
        line.waiting.append(_WaitingMessage(item, size, now_us, kept))
        line.bytes += size
        self.bytes += size
        while len(line.waiting) > 1 and (
            line.bytes > self._share or now_us - line.waiting[0].at_us > self._age_us
        ):
            # One to be kept is sent before those behind it, so they wait for it.
            if line.waiting[0].kept:
                break
            self._drop_oldest(line)
        # Beside the newest, so that one that is larger than all that may wait pushes nothing out.
        while self.bytes - size > self._most:
            self._drop_largest(but=topic)

    def next_message(self, skip: Container[Hashable] = ()) -> tuple[Hashable, Item] | None:
        """Give the oldest message of the topic whose turn it is, of those not in ``skip``."""
        for topic, line in self._lines.items():
            if topic not in skip:
                oldest = line.pop_oldest()
                self.bytes -= oldest.size
                # Its next turn comes behind all others.
                del self._lines[topic]
                if line.waiting:
                    self._lines[topic] = line
                return topic, oldest.item
        return None

    def remove_topic(self, topic: Hashable) -> None:
        """Forget what waits of a topic."""
        line = self._lines.pop(topic, None)
        if line is not None:
            self.bytes -= line.bytes

    def clear(self) -> None:
        """Forget all that waits."""
        self._lines.clear()
        self.bytes = 0

    def _drop_largest(self, but: Hashable) -> None:
        """Leave out the oldest of the largest line; the newest of a line only for want of others.

        Args:
            but: the topic whose newest message has just come, and stays.

        """
        several = [topic for topic, line in self._lines.items() if len(line.waiting) > 1]
        others = several or [topic for topic in self._lines if topic != but]
        topic = max(others, key=lambda one: self._lines[one].bytes)
        self._drop_oldest(self._lines[topic])
        if not self._lines[topic].waiting:
            del self._lines[topic]

    def _drop_oldest(self, line: _TopicLine[Item]) -> None:
        self.bytes -= line.pop_oldest().size
        self.dropped += 1
