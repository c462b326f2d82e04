"""Signals that one Foxglove client subscribed to, and their samples as its messages. Pure."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.clients.foxglove.offer import FoxgloveOffer
from talaia.hub.clients.foxglove.schemas import encode_frame, encode_sample
from talaia.hub.clients.signal_subscriptions import SignalSubscriptions

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Iterator

    from talaia.hub.clients.signal_subscriptions import ClientSample
    from talaia.wire.browser import Subscribe, Unsubscribe, Values

__all__ = ["ChannelMessage", "SignalChannels"]


class ChannelMessage(NamedTuple):
    """A message of a channel: its topic, when it was sampled (µs, UTC), and its JSON."""

    topic: str
    time_us: int
    data: bytes


class SignalChannels:
    """Send what the methods give to the hub, in its order."""

    def __init__(self, site: str, *, wants: Callable[[str], bool]) -> None:
        """Start with nothing that is offered; ``wants`` tells whether a topic is subscribed to."""
        self._offer = FoxgloveOffer()
        # Single wishes are few subscriptions at the hub.
        self._subscriptions = SignalSubscriptions(site)
        # Of the offer of now, for samples come by address: a position is two topics.
        self._topics_of: dict[str, list[str]] = {}
        # A topic that nobody wants costs nothing.
        self._wants = wants
        # By topic: what is known of a position's parts, or of the single one.
        self._parts: dict[str, dict[str, float | str]] = {}

    def update_offer(self, offer: FoxgloveOffer) -> None:
        """Go by another offer; topics that are gone were removed before."""
        # Schemas and parts may be others, too.
        self._offer = offer
        self._topics_of = {}
        for topic, offered in offer.signals.items():
            for address in offered.addresses:
                self._topics_of.setdefault(address, []).append(topic)

    def add_topics(self, topics: Collection[str]) -> list[Subscribe | Unsubscribe]:
        """Subscribe to those of the topics that are signals."""
        offered = (self._offer.signals.get(topic) for topic in topics)
        added = [address for one in offered if one is not None for address in one.addresses]
        # What comes already comes anew, for the newest values are for the new topic as well.
        again = [address for address in added if address in self._subscriptions.wanted]
        return [
            *self._subscriptions.remove_addresses(again),
            *self._subscriptions.add_addresses(added),
        ]

    def remove_topics(self, topics: Collection[str]) -> list[Subscribe | Unsubscribe]:
        """Subscribe to them no more."""
        for topic in topics:
            self._parts.pop(topic, None)
        return self._subscriptions.remove_addresses(
            [
                address
                for address, named in self._topics_of.items()
                if any(topic in topics for topic in named)
                and not any(self._wants(topic) for topic in named if topic not in topics)
            ]
        )

    def read_messages(self, values: Values) -> Iterator[ChannelMessage]:
        """Give the messages that samples make."""
        yield from self.compose_messages(self._subscriptions.read_samples(values))

    def compose_messages(self, samples: Iterable[ClientSample]) -> Iterator[ChannelMessage]:
        """Give the messages that samples of offered signals make, in their order of time."""
        # Parts of a position come one after the other with one time; they are one message.
        waiting: dict[str, int] = {}
        for sample in samples:
            for topic in filter(self._wants, self._topics_of.get(sample.address, ())):
                if waiting.get(topic, sample.time_us) != sample.time_us:
                    yield from self._message(topic, waiting[topic])
                # The newest time: what is known of the other parts goes out with it.
                waiting[topic] = sample.time_us
                _note_part(self._parts.setdefault(topic, {}), sample)
        for topic, time_us in waiting.items():
            yield from self._message(topic, time_us)

    def forget_parts(self) -> None:
        """Forget what is known of positions: what comes is of another time."""
        self._parts.clear()

    def _message(self, topic: str, time_us: int) -> Iterator[ChannelMessage]:
        # Either may have gone while another message was on its way.
        offered, parts = self._offer.signals.get(topic), self._parts.get(topic)
        if offered is None or parts is None:
            return
        # None while a part is missing without which it says nothing.
        if offered.child:
            data = encode_frame(offered.child, parts, time_us)
        else:
            data = encode_sample(offered.signal, parts, time_us)
        if data is not None:
            yield ChannelMessage(topic, time_us, data)


def _note_part(parts: dict[str, float | str], sample: ClientSample) -> None:
    # A single one has the empty name.
    part = sample.address.partition(".")[2]
    known = sample.text if sample.text is not None else sample.value
    parts[part] = known if isinstance(known, str) or math.isfinite(known) else math.nan
