"""What is known and tapped of one site's topics; no rights here, and nobody is told anything."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from talaia.hub.live.taps.reassembly import PieceReassembly
from talaia.hub.live.taps.tapped import TappedMessage
from talaia.wire.frames import TapSubscription

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.hub.live.taps.taker import TopicTap
    from talaia.wire.frames import TapMessage, TapSchema, TopicEntry

__all__ = ["SiteTopics", "TappedTopic"]

# Of a latched topic, held for those who come later: so many messages, so many bytes beside the
# newest.
_MOST_LATCHED, _LATCHED_BYTES = 100, 4 * 1024 * 1024
# Messages by which it is told how often a topic comes.
_COUNTED = 20


class TappedTopic:
    """One topic that is tapped, once for all who take it.

    Attributes:
        taps: who takes it.
        latched: its last messages, for those who come later; empty where it is not latched.

    """

    def __init__(self) -> None:
        """Begin with nobody."""
        self.taps: set[TopicTap] = set()
        self.latched: deque[TappedMessage] = deque(maxlen=_MOST_LATCHED)
        # Of its last messages: their numbers, with those left out, and when they came (µs).
        self._counted: deque[tuple[int, int]] = deque(maxlen=_COUNTED)

    def count_message(self, seq: int, log_us: int) -> None:
        """Count a message for `measured_rate`."""
        if self._counted and seq <= self._counted[-1][0]:
            # Another run of the gateway, or it was asked for anew.
            self._counted.clear()
        self._counted.append((seq, log_us))

    def measured_rate(self) -> float:
        """Give how often the robot publishes it (Hz); 0 while that is not known."""
        if len(self._counted) < 2:
            return 0.0
        (first, began_us), (last, ended_us) = self._counted[0], self._counted[-1]
        return (last - first) * 1e6 / (ended_us - began_us) if ended_us > began_us else 0.0

    def rate(self) -> float:
        """Give the greatest rate that anyone wants (Hz); 0: all messages."""
        rates = [tap.max_rate for tap in self.taps]
        return 0.0 if 0.0 in rates else max(rates, default=0.0)

    def hold_latched(self, message: TappedMessage) -> None:
        """Hold a message for those who come later; the oldest give way."""
        self.latched.append(message)
        held = sum(len(held_one.data) for held_one in self.latched) - len(message.data)
        while held > _LATCHED_BYTES:
            held -= len(self.latched.popleft().data)


class SiteTopics:
    """One site.

    Attributes:
        entries: the topics that its gateway has listed, by name; those of the last link while it
            is away.
        schemas: of the types that were asked for on this link.
        tapped: what is taken, by topic.

    """

    def __init__(self) -> None:
        """Begin with nothing known."""
        self.entries: dict[str, TopicEntry] = {}
        self.schemas: dict[str, TapSchema] = {}
        self.tapped: dict[str, TappedTopic] = {}
        # Types that somebody asks for beside those of what is tapped.
        self.types: set[str] = set()
        self._by_number: dict[int, TopicEntry] = {}
        self._pieces = PieceReassembly()

    def replace_entries(self, entries: list[TopicEntry]) -> None:
        """Take another list of topics."""
        self.entries = {entry.topic: entry for entry in entries}
        self._by_number = {entry.number: entry for entry in entries}

    def end_link(self) -> None:
        """Forget what holds only while a link stands; lists and takers stay."""
        self.schemas.clear()
        self._pieces.clear()
        for tapped in self.tapped.values():
            # They come anew with the next link.
            tapped.latched.clear()

    def end_media(self) -> None:
        """Forget messages that are not whole: the connection is another one."""
        self._pieces.clear()

    def schema_of(self, topic: str) -> TapSchema | None:
        """Give how messages of a topic are read, as far as it is known."""
        entry = self.entries.get(topic)
        return None if entry is None else self.schemas.get(entry.type)

    def subscription(
        self, most_rate: Callable[[str], float], *, graph: bool = False
    ) -> TapSubscription:
        """Say what is wanted of the gateway.

        A topic is asked for once its schema is known, so that no message comes before it.

        Args:
            most_rate: gives a topic's greatest rate by the description (Hz); 0: all messages.
            graph: somebody wants to know the robot's nodes.

        """
        topics, types = {}, set(self.types)
        for topic, tapped in self.tapped.items():
            entry = self.entries.get(topic)
            if entry is None or not tapped.taps:
                continue
            if entry.type in self.schemas:
                rates = [rate for rate in (tapped.rate(), most_rate(topic)) if rate]
                topics[topic] = min(rates, default=0.0)
            else:
                types.add(entry.type)
        return TapSubscription(
            topics=topics, types=sorted(types - self.schemas.keys()), graph=graph
        )

    def measured_rate(self, topic: str) -> float:
        """Give how often a topic comes (Hz); 0 while nobody takes it."""
        tapped = self.tapped.get(topic)
        return 0.0 if tapped is None else tapped.measured_rate()

    def read_message(self, piece: TapMessage, now_ms: int = 0) -> TappedMessage | None:
        """Give the message that a piece completes, if anybody takes it; ``now_ms``: monotonic.

        Raises:
            PeerError: see `PieceReassembly.add_piece`.

        """
        entry = self._by_number.get(piece.number)
        # On its way when nobody wanted it any more.
        if entry is None or entry.topic not in self.tapped:
            self._pieces.forget_topic(piece.number)
            return None
        data = self._pieces.add_piece(piece)
        if data is None:
            return None
        message = TappedMessage(
            entry.topic, piece.seq, piece.log_us, piece.publish_us, piece.kept, data, now_ms
        )
        self.tapped[entry.topic].count_message(piece.seq, piece.log_us)
        if entry.latched:
            self.tapped[entry.topic].hold_latched(message)
        return message
