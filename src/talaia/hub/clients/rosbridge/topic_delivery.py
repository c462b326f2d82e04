"""What one client has subscribed to on its way to it: signals and raw topics, each in its form."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, NamedTuple, Protocol

from talaia.clock import SECOND
from talaia.hub.clients.rosbridge.offer import RosbridgeOffer, full_type
from talaia.hub.clients.rosbridge.throttling import TopicThrottles
from talaia.hub.clients.rosbridge.topic_messages import (
    TopicFrames,
    encode_sample_frames,
    encode_tapped_frames,
)
from talaia.hub.clients.rosbridge.wanted_topics import WantedTopics, absolute_name
from talaia.hub.clients.signal_subscriptions import ClientSample, SignalSubscriptions
from talaia.hub.errors import TapRefused
from talaia.hub.live.taps.tapped import (
    GraphChanged,
    TapBegun,
    TapDelivery,
    TapEnded,
    TappedMessage,
    TapTrouble,
    TopicsChanged,
)
from talaia.hub.live.taps.type_texts import MessageUnreadable

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.clients.rosbridge.wanted_topics import TopicForm
    from talaia.hub.live.taps.taker import TopicTap
    from talaia.hub.live.taps.tap_fanout import TapFanout
    from talaia.wire.browser import Values
    from talaia.wire.frames import TapSchema
    from talaia.wire.rosbridge.client_messages import RosbridgeSubscribe, RosbridgeUnsubscribe

__all__ = ["TopicDelivery"]

# What waits for a client's throttles (bytes, beside the newest message of each topic).
_MOST_WAITING = 2 * 1024 * 1024
# Throttles are looked after no oftener than this (s): one look sends what is due of all topics.
_LEAST_WAIT_S = 0.005
# A larger message is read beside the event loop (bytes).
_LARGE = 16 * 1024


class RosbridgeClient(Protocol):
    """The client's side of a session."""

    async def send_frames(self, frames: list[str | bytes]) -> None:
        """Write frames of one message; returns when there is room for more."""
        ...

    async def tell_status(self, level: str, text: str, message_id: str | int | None = None) -> None:
        """Tell the client's person something."""
        ...


class _Tapped(NamedTuple):
    """A raw message, with how it is read."""

    schema: TapSchema
    message: TappedMessage


class TopicDelivery:
    """The subscriptions of one client at one site."""

    def __init__(
        self,
        connection: ClientConnection,
        client: RosbridgeClient,
        *,
        taps: TapFanout,
        clock: Clock,
    ) -> None:
        """Deliver to ``client`` what ``connection`` and ``taps`` give its account."""
        self._connection = connection
        self._client = client
        self._taps = taps
        self._clock = clock
        self._site = connection.live.name
        self._offer = RosbridgeOffer()
        self._wanted = WantedTopics()
        # By topic: the name by which the client knows it, and the form in which it goes.
        self._goes: dict[str, tuple[str, TopicForm]] = {}
        self._signals = SignalSubscriptions(self._site)
        # By topic.
        self._address_of: dict[str, str] = {}
        self._tapped: dict[str, TopicTap] = {}
        self._schemas: dict[str, TapSchema] = {}
        # Topics of which it has been said that they cannot be read.
        self._unreadable: set[str] = set()
        self._throttles: TopicThrottles[ClientSample | _Tapped] = TopicThrottles(_MOST_WAITING)
        self._throttled = asyncio.Event()
        self._taker = taps.taker(connection.who.grants)
        taps.follow_topics(self._site, self._taker)
        self._number = 0

    def end_delivery(self) -> None:
        """Take nothing more."""
        self._taps.remove_taker(self._taker)

    def update_offer(self, offer: RosbridgeOffer) -> None:
        """Go by another offer: what is wanted may be there now, or not any more."""
        self._offer = offer
        self._address_of = {topic: address for address, topic in offer.addresses.items()}
        wanted = self._wanted.topics()
        gone = [address for address in self._signals.wanted if address not in offer.addresses]
        for asked in self._signals.remove_addresses(gone):
            self._connection.request(asked)
        self._take_topics(wanted)

    # ── what the client asks ──

    async def add_subscription(self, asked: RosbridgeSubscribe, kind: str) -> None:
        """Subscribe; ``kind`` is the topic's type as far as it is known, else empty."""
        topic = absolute_name(asked.topic)
        if asked.type and kind and full_type(asked.type) != kind:
            why = f"{asked.topic} is of the type {kind}, not {full_type(asked.type)}"
            await self._client.tell_status("error", why, asked.id)
            return
        if not asked.type and not kind:
            why = f"there is no topic {asked.topic}; with its type you may wait for it"
            await self._client.tell_status("error", why, asked.id)
            return
        problem = self._wanted.add_subscription(asked)
        if problem:
            await self._client.tell_status("error", problem, asked.id)
        if self._change_form(topic, asked.topic):
            self._take_topics([topic])

    async def remove_subscription(self, asked: RosbridgeUnsubscribe) -> None:
        """End one subscription of a topic, or all of it."""
        topic = absolute_name(asked.topic)
        if not self._wanted.remove_subscription(asked):
            why = f"there is no such subscription to {asked.topic}"
            await self._client.tell_status("warning", why, asked.id)
            return
        if self._change_form(topic, asked.topic):
            self._take_topics([topic])
            return
        tap = self._tapped.pop(topic, None)
        if tap is not None:
            self._taps.unsubscribe(tap)
        address = self._address_of.get(topic)
        for request in self._signals.remove_addresses([] if address is None else [address]):
            self._connection.request(request)

    def _change_form(self, topic: str, name: str) -> bool:
        """Go by what is wanted of a topic now; tell whether anything is."""
        form = self._wanted.form_of(topic)
        if form is None:
            self._goes.pop(topic, None)
            self._throttles.forget_topic(topic)
            return False
        self._goes[topic] = name, form
        self._throttles.set_throttle(topic, interval_ms=form.throttle_ms, queue=form.queue)
        return True

    def _take_topics(self, topics: list[str]) -> None:
        """Ask for those of the topics that are there; the others may come later."""
        addresses = []
        for topic in topics:
            address = self._address_of.get(topic)
            if address is not None:
                addresses.append(address)
            else:
                self._tap_topic(topic)
        for asked in self._signals.add_addresses(addresses):
            self._connection.request(asked)

    def _tap_topic(self, topic: str) -> None:
        form = self._wanted.form_of(topic)
        if form is None:
            return
        # With a queue all messages count; without one the gateway may thin them out already.
        rate = 1000 / form.throttle_ms if form.throttle_ms and form.queue <= 1 else 0.0
        tap = self._tapped.get(topic)
        if tap is not None and tap.max_rate == rate:
            return
        try:
            self._tapped[topic] = self._taps.subscribe(
                self._site, topic, self._taker, max_rate=rate
            )
        except TapRefused:
            # As if it were not there; it is tried again when the list of topics changes.
            self._tapped.pop(topic, None)

    # ── what comes ──

    async def deliver_values(self, values: Values) -> None:
        """Send the samples of a message that are wanted."""
        for sample in self._signals.read_samples(values):
            topic = self._offer.addresses.get(sample.address)
            if topic is not None:
                await self._deliver_item(topic, sample, 64)

    async def send_taps(self) -> None:
        """Send raw messages as they come, until cancelled."""
        while True:
            event = await self._taker.next_event()
            match event:
                case TapBegun():
                    self._schemas[event.tap.topic] = event.schema
                    self._unreadable.discard(event.tap.topic)
                case TapDelivery():
                    topic = event.tap.topic
                    schema = self._schemas.get(topic)
                    if schema is not None:
                        tapped = _Tapped(schema, event.message)
                        await self._deliver_item(topic, tapped, len(event.message.data))
                case TapTrouble():
                    await self._client.tell_status("warning", f"{event.tap.topic}: {event.why}")
                case TapEnded():
                    self._tapped.pop(event.tap.topic, None)
                    await self._client.tell_status("error", f"{event.tap.topic}: {event.why}")
                case TopicsChanged():
                    self._take_topics(self._wanted.topics())
                case GraphChanged():
                    # Clients of this protocol ask for nodes, and are told nothing by themselves.
                    pass

    async def send_throttled(self) -> None:
        """Send what waited for its throttle when it is due, until cancelled."""
        while True:
            self._throttled.clear()
            due_ns = self._throttles.due_ns()
            if due_ns is None:
                await self._throttled.wait()
                continue
            wait_s = (due_ns - self._clock.monotonic_ns()) / SECOND
            await asyncio.sleep(max(_LEAST_WAIT_S, wait_s))
            for topic, item in list(self._throttles.pop_due(self._clock.monotonic_ns())):
                await self._send_item(topic, item)

    async def _deliver_item(self, topic: str, item: ClientSample | _Tapped, size: int) -> None:
        if topic not in self._goes:
            return
        if self._throttles.admit_message(topic, item, size, self._clock.monotonic_ns()):
            await self._send_item(topic, item)
        else:
            self._throttled.set()

    async def _send_item(self, topic: str, item: ClientSample | _Tapped) -> None:
        # It may have ended while another message was sent.
        goes = self._goes.get(topic)
        if goes is None:
            return
        self._number += 1
        frames = TopicFrames(*goes, self._number)
        if isinstance(item, ClientSample):
            signal = self._offer.signals.get(topic)
            if signal is not None:
                await self._client.send_frames(encode_sample_frames(frames, signal, item))
            return
        try:
            if len(item.message.data) > _LARGE:
                encoded = await asyncio.to_thread(
                    encode_tapped_frames, frames, item.schema, item.message
                )
            else:
                encoded = encode_tapped_frames(frames, item.schema, item.message)
        except MessageUnreadable as error:
            if topic not in self._unreadable:
                self._unreadable.add(topic)
                await self._client.tell_status("error", f"{topic}: {error}")
            return
        await self._client.send_frames(encoded)
