"""What one client has subscribed to, by topic, and how it wants it. Pure."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from talaia.wire.rosbridge.fragments import LEAST_FRAGMENT

if TYPE_CHECKING:
    from talaia.wire.rosbridge.client_messages import RosbridgeSubscribe, RosbridgeUnsubscribe

__all__ = ["MOST_WANTED", "TopicForm", "WantedTopics", "absolute_name", "fragment_size_of"]

# Subscriptions of one client; several may be of one topic.
MOST_WANTED = 2000
# Where a client subscribes twice, the later of these counts.
_COMPRESSIONS = ("none", "cbor", "cbor-raw")


class TopicForm(NamedTuple):
    """How a topic goes to a client.

    Attributes:
        throttle_ms: at least so long between two messages.
        queue: so many wait for it.
        fragment_size: letters of a fragment; 0: whole messages.
        compression: ``none``, ``cbor`` or ``cbor-raw``.

    """

    throttle_ms: float
    queue: float
    fragment_size: int
    compression: str


class WantedTopics:
    """By topic and the client's own id: what it asked for."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self._wanted: dict[str, dict[str | int | None, TopicForm]] = {}
        self._count = 0

    def form_of(self, topic: str) -> TopicForm | None:
        """Give how a topic goes; None: it is not wanted.

        Of several subscriptions the protocol takes the least throttle, the smallest fragments and
        the longest queue.
        """
        forms = self._wanted.get(topic)
        if forms is None:
            return None
        return TopicForm(
            min(form.throttle_ms for form in forms.values()),
            max(form.queue for form in forms.values()),
            min((form.fragment_size for form in forms.values() if form.fragment_size), default=0),
            max((form.compression for form in forms.values()), key=_COMPRESSIONS.index),
        )

    def topics(self) -> list[str]:
        """List what is wanted."""
        return list(self._wanted)

    def add_subscription(self, asked: RosbridgeSubscribe) -> str:
        """Take a subscription; one of the same topic and id is replaced. Say why not, if so."""
        topic = absolute_name(asked.topic)
        forms = self._wanted.get(topic, {})
        if asked.id not in forms:
            if self._count >= MOST_WANTED:
                return f"at most {MOST_WANTED} subscriptions; end some first"
            self._count += 1
        compression = asked.compression or "none"
        self._wanted.setdefault(topic, {})[asked.id] = TopicForm(
            _positive_or_zero(asked.throttle_rate),
            _positive_or_zero(asked.queue_length),
            fragment_size_of(asked.fragment_size),
            compression if compression in _COMPRESSIONS else "none",
        )
        if compression not in _COMPRESSIONS:
            return f"there is no compression {compression[:40]!r} here: {', '.join(_COMPRESSIONS)}"
        return ""

    def remove_subscription(self, asked: RosbridgeUnsubscribe) -> bool:
        """End a subscription, all of the topic without an id; tell whether there was one."""
        topic = absolute_name(asked.topic)
        forms = self._wanted.get(topic)
        if forms is None:
            return False
        ended = list(forms) if asked.id is None else [asked.id]
        found = [forms.pop(number) for number in ended if number in forms]
        self._count -= len(found)
        if not forms:
            del self._wanted[topic]
        return bool(found)


def absolute_name(name: str) -> str:
    """Give a topic's or service's absolute name; clients may leave out the slash."""
    return name if name.startswith("/") else f"/{name}"


def fragment_size_of(asked: float | None) -> int:
    """Give the letters of a fragment that a client wants; 0: whole messages."""
    size = _positive_or_zero(asked)
    return max(LEAST_FRAGMENT, int(min(size, 2.0**31))) if size else 0


def _positive_or_zero(number: float | None) -> float:
    return number if number is not None and math.isfinite(number) and number > 0 else 0.0
