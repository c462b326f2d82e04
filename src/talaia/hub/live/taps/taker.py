"""One who takes raw topics: a client's connection, a page, a recorder. Bounded, whoever reads."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.hub.live.taps.tapped import (
    GraphChanged,
    TapBegun,
    TapDelivery,
    TapEnded,
    TapEvent,
    TappedMessage,
    TapTrouble,
    TopicsChanged,
)
from talaia.wire.topic_queue import RateGate, TopicQueue

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.hub.auth.permissions import Grants
    from talaia.wire.frames import TapSchema

__all__ = ["MOST_TAPS", "TapTaker", "TopicTap"]

# Taps of one taker.
MOST_TAPS = 1000
# Bytes that may wait for one taker, beside the newest message; and of them of one topic that comes
# often. They are the same bytes for all takers.
_MOST_WAITING, _SHARE = 4 * 1024 * 1024, 1024 * 1024
# Of a topic that comes often, what is so much older than its newest is of no use (µs).
_AGE_US = 1_000_000


class TopicTap:
    """One topic for one taker; made by `TapFanout.subscribe`, ended by `TapFanout.unsubscribe`.

    Attributes:
        site: short name of the site.
        topic: absolute name.
        taker: who gets it.
        max_rate: at most so many messages a second (Hz); 0: all. Of a topic that is latched or
            comes seldom, all.
        schema: as the taker was told it last; None before it is known.

    """

    __slots__ = ("_gate", "max_rate", "schema", "site", "taker", "topic")

    def __init__(self, *, site: str, topic: str, taker: TapTaker, max_rate: float) -> None:
        """See above."""
        self.site = site
        self.topic = topic
        self.taker = taker
        self.max_rate = max_rate
        self.schema: TapSchema | None = None
        self._gate = RateGate(max_rate)

    def wants(self, message: TappedMessage) -> bool:
        """Tell whether a message is for its taker, by its rate; then it counts."""
        return self._gate.passes(message.log_us) or message.kept


class TapTaker:
    """Who takes, with what waits for them; made by `TapFanout.taker`.

    What waits is bounded, so that a taker may read as slowly as its own line is: it awaits
    `next_event`, sends what that gives, awaits that its line has taken it, and comes again. What is
    too much for it meanwhile is left out, the oldest first, and holds up nobody else.

    Attributes:
        grants: the person's rights; None for the hub itself, which may take everything.
        taps: what it takes, by site and topic.

    """

    def __init__(
        self,
        grants: Grants | None,
        *,
        now_us: Callable[[], int],
        most_bytes: int = _MOST_WAITING,
    ) -> None:
        """See above; ``now_us`` is monotonic."""
        self.grants = grants
        self.taps: dict[tuple[str, str], TopicTap] = {}
        self._now_us = now_us
        self._queue: TopicQueue[TappedMessage] = TopicQueue(
            share=min(_SHARE, most_bytes), most=most_bytes, age_us=_AGE_US
        )
        # What is told before all messages, the newest of each kind and tap.
        self._notices: dict[object, TapEvent] = {}
        self._wake = asyncio.Event()

    @property
    def waiting_bytes(self) -> int:
        """How many bytes of messages wait."""
        return self._queue.bytes

    @property
    def dropped(self) -> int:
        """How many messages were left out for want of reading."""
        return self._queue.dropped

    async def next_event(self) -> TapEvent:
        """Wait for what is to be told or handed over next; notices come before messages."""
        while (event := self.pop_event()) is None:
            self._wake.clear()
            await self._wake.wait()
        return event

    def pop_event(self) -> TapEvent | None:
        """Give what `next_event` would, without waiting; None when nothing waits."""
        for key in self._notices:
            return self._notices.pop(key)
        found = self._queue.next_message()
        if found is None:
            return None
        tap, message = found
        assert isinstance(tap, TopicTap)  # noqa: S101 - told to mypy: the queue's keys are taps
        return TapDelivery(tap, message)

    # ── for `TapFanout` ──

    def begin_tap(self, tap: TopicTap, schema: TapSchema) -> None:
        """Tell how the next messages are read; those that wait are of another schema."""
        if tap.schema != schema:
            tap.schema = schema
            self._queue.remove_topic(tap)
            self._notify((TapBegun, tap), TapBegun(tap, schema))

    def deliver_message(self, tap: TopicTap, message: TappedMessage) -> None:
        """Hand a message over."""
        if tap.wants(message):
            size, now_us = len(message.data), self._now_us()
            self._queue.add(tap, message, size, now_us=now_us, kept=message.kept)
            self._wake.set()

    def report_trouble(self, tap: TopicTap, why: str) -> None:
        """Tell why messages are missing."""
        self._notify((TapTrouble, tap), TapTrouble(tap, why))

    def report_topics(self, site: str) -> None:
        """Tell that the topics of a site have changed."""
        self._notify((TopicsChanged, site), TopicsChanged(site))

    def report_graph(self, site: str) -> None:
        """Tell that the nodes of a site, or what they have, have changed."""
        self._notify((GraphChanged, site), GraphChanged(site))

    def forget_tap(self, tap: TopicTap, why: str = "") -> None:
        """Forget a tap and all that waits of it; with ``why``, tell that it is over."""
        if self.taps.get((tap.site, tap.topic)) is tap:
            del self.taps[tap.site, tap.topic]
        self._queue.remove_topic(tap)
        for kind in (TapBegun, TapTrouble):
            self._notices.pop((kind, tap), None)
        if why:
            self._notify((TapEnded, tap), TapEnded(tap, why))

    def _notify(self, key: object, event: TapEvent) -> None:
        # Behind what was told before: of one kind and tap the newest counts.
        self._notices.pop(key, None)
        self._notices[key] = event
        self._wake.set()
