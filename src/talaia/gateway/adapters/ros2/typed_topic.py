"""One topic's messages, held back until it is known how they are read. On the wait-set thread."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from talaia.gateway.adapters.ros2.topic_types import TopicType, TopicTypes

__all__ = ["Deliver", "TypedTopic"]

# Messages that wait until it is known how they are read; a latched one must not be lost.
_MAX_HELD = 100
_MAX_HELD_BYTES = 8 * 1024 * 1024


Deliver = Callable[[bytes, int, int], None]


class TypedTopic:
    """One topic's messages, held back until it is known how they are read.

    Attributes:
        deliver: takes a message: its bytes, and when it came by the wall clock (µs) and by the
            monotonic one (ns); None while it is not known how it is read: see `hold_message`.

    """

    def __init__(
        self,
        topic: str,
        type_name: str,
        types: TopicTypes,
        deliver_as: Callable[[TopicType], Deliver],
    ) -> None:
        """Take who finds the type, and who takes messages.

        Args:
            topic: absolute.
            type_name: ``package/msg/Name``.
            types: see above.
            deliver_as: makes `deliver` of how a message is read.

        """
        self._topic, self._type_name = topic, type_name
        self._types = types
        self._deliver_as = deliver_as
        self.deliver: Deliver | None = None
        # Their publishers' hash; None before there are any.
        self._spoken: str | None = None
        self._refused = False
        # Oldest first.
        self._held: list[tuple[bytes, int, int]] = []
        self._held_bytes = 0

    def set_publishers(self, hashes: frozenset[str]) -> None:
        """Take the hashes that the topic's publishers tell; empty ones of those that tell none."""
        told = sorted(hashes - {""})
        # Of publishers that tell none nothing can be compared; they count as the others.
        if len(told) > 1:
            self.deliver, self._spoken, self._refused = None, None, True
            self._clear()
            versions = " and ".join(told)
            self._types.refuse(
                self._topic,
                f"{self._type_name} is published in two versions, {versions}: it is not read "
                "until one of the publishers ends, for nothing tells whose a message is",
            )
            return
        spoken = told[0] if told else ""
        if spoken == self._spoken:
            return
        self.deliver, self._spoken, self._refused = None, spoken, False

        def on_found(found: TopicType | None) -> None:
            # Another publisher may have come meanwhile.
            if self._spoken == spoken and not self._refused:
                self._on_found(found)

        self._types.find(self._topic, self._type_name, spoken, on_found)

    def _on_found(self, found: TopicType | None) -> None:
        self._refused = found is None
        if found is not None:
            self.deliver = self._deliver_as(found)
            # With the times at which they came, so that nobody sees that they waited.
            for raw, time_us, mono_ns in self._held:
                self.deliver(raw, time_us, mono_ns)
        self._clear()

    def hold_message(self, raw: bytes, time_us: int, mono_ns: int) -> None:
        """Take a message while there is no `deliver`; of what cannot be read it is left out."""
        if self._refused:
            return
        self._held.append((raw, time_us, mono_ns))
        self._held_bytes += len(raw)
        while len(self._held) > _MAX_HELD or self._held_bytes > _MAX_HELD_BYTES:
            self._held_bytes -= len(self._held.pop(0)[0])

    def _clear(self) -> None:
        self._held, self._held_bytes = [], 0
