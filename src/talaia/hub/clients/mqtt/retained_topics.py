"""What the broker is to keep for each topic: the newest only, however slow it is. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable

__all__ = ["RetainedTopics"]


class RetainedTopics:
    """Topics with their payloads, and which of them the broker has not been told yet.

    Attributes:
        revision: another one whenever `known` is not as it was.

    It holds one payload for each topic, so what waits for a slow broker is bounded by the
    description, and what it is told is always the newest.
    """

    def __init__(self, known: Iterable[str] = ()) -> None:
        """Start with nothing; ``known`` are topics that were published by an earlier run."""
        self._wanted: dict[str, bytes] = {}
        # What was sent on this connection.
        self._sent: dict[str, bytes] = {}
        # All that the broker may hold of ours; cleared before it is forgotten.
        self._known = set(known)
        # In the order in which they became due.
        self._due: dict[str, None] = {}
        # Counts changes of what is known.
        self.revision = 0

    @property
    def known(self) -> frozenset[str]:
        """All topics that the broker may hold."""
        return frozenset(self._known)

    @property
    def has_due(self) -> bool:
        """Whether the broker is to be told something."""
        return bool(self._due)

    def set_payload(self, topic: str, payload: bytes) -> None:
        """Have a topic hold ``payload``."""
        self._wanted[topic] = payload
        if self._sent.get(topic) != payload:
            self._due[topic] = None
        else:
            self._due.pop(topic, None)

    def keep_only(self, topics: Collection[str]) -> None:
        """Clear every topic but these."""
        for topic in (self._known | self._wanted.keys()) - set(topics):
            self._wanted.pop(topic, None)
            if topic in self._known:
                self._due[topic] = None
            else:
                self._due.pop(topic, None)

    def forget_topics(self, topics: Collection[str]) -> None:
        """Leave topics as they are at the broker from now on: somebody else sees to them."""
        for topic in self._known & set(topics):
            self._known.discard(topic)
            self._wanted.pop(topic, None)
            self._due.pop(topic, None)
            self.revision += 1

    def withhold_values(self) -> None:
        """Send nothing that is not set again: whoever set it may not have it any more."""
        self._wanted.clear()
        self._due.clear()

    def restart_connection(self) -> None:
        """Begin a connection: the broker may have forgotten everything."""
        self._sent.clear()
        self._due = dict.fromkeys(self._wanted)

    def take_due(self) -> tuple[str, bytes] | None:
        """Give the next topic and what it is to hold; empty clears it. None: all are told."""
        if not self._due:
            return None
        topic = next(iter(self._due))
        del self._due[topic]
        payload = self._wanted.get(topic, b"")
        if payload:
            self.revision += topic not in self._known
            self._known.add(topic)
            self._sent[topic] = payload
        else:
            self._sent.pop(topic, None)
        return topic, payload

    def confirm_cleared(self, topic: str) -> None:
        """Forget a topic that the broker has cleared."""
        if topic not in self._wanted and topic in self._known:
            self._known.remove(topic)
            self.revision += 1
