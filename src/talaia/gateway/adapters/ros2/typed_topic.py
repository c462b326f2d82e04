"""One topic's messages, held back until it is known how they are read. On the wait-set thread."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.ros2.topic_types import TopicType, TopicTypes

__all__ = ["TypedTopic"]

# Messages that wait until it is known how they are read; a latched one must not be lost.
_MAX_HELD = 100
_MAX_HELD_BYTES = 8 * 1024 * 1024


class TypedTopic:
    """One topic's messages, held back until it is known how they are read."""

    def __init__(
        self,
        topic: str,
        type_name: str,
        types: TopicTypes,
        deliver: Callable[[TopicType, bytes, int, int], None],
    ) -> None:
        """Take who finds the type, and who takes messages.

        Args:
            topic: absolute.
            type_name: ``package/msg/Name``.
            types: see above.
            deliver: takes how a message is read, its bytes, and when it came: by the wall clock
                (µs), and by the monotonic one (ns).

        """
        self._topic, self._type_name = topic, type_name
        self._types = types
        self._deliver = deliver
        self._type: TopicType | None = None
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
            self._type, self._spoken, self._refused = None, None, True
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
        self._type, self._spoken, self._refused = None, spoken, False

        def on_found(found: TopicType | None) -> None:
            # Another publisher may have come meanwhile.
            if self._spoken == spoken and not self._refused:
                self._on_found(found)

        self._types.find(self._topic, self._type_name, spoken, on_found)

    def read_message(self, raw: bytes, time_us: int, mono_ns: int) -> None:
        """Take a message; what cannot be read is left out."""
        if self._type is not None:
            self._deliver(self._type, raw, time_us, mono_ns)
        elif not self._refused:
            self._hold(raw, time_us, mono_ns)

    def _on_found(self, found: TopicType | None) -> None:
        self._type, self._refused = found, found is None
        if found is not None:
            # With the times at which they came, so that nobody sees that they waited.
            for raw, time_us, mono_ns in self._held:
                self._deliver(found, raw, time_us, mono_ns)
        self._clear()

    def _hold(self, raw: bytes, time_us: int, mono_ns: int) -> None:
        self._held.append((raw, time_us, mono_ns))
        self._held_bytes += len(raw)
        while len(self._held) > _MAX_HELD or self._held_bytes > _MAX_HELD_BYTES:
            self._held_bytes -= len(self._held.pop(0)[0])

    def _clear(self) -> None:
        self._held, self._held_bytes = [], 0
