"""One site at the broker: its newest values, how it stands, and commands for it."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Protocol

from talaia.hub.clients.mqtt.channel_reading import is_reached, read_channel, reading_mark
from talaia.hub.clients.mqtt.command_relay import CommandRelay
from talaia.hub.clients.mqtt.publication import SitePublication, make_publication
from talaia.wire.mqtt.payloads import OFFLINE, ONLINE, ValueQuality, encode_value

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.clients.mqtt.asked_commands import InboundMessage, RefusedMessage
    from talaia.hub.clients.mqtt.broker_settings import SiteChoice
    from talaia.hub.clients.mqtt.publication import PublishedChannel
    from talaia.wire.browser import ToBrowser
    from talaia.wire.mqtt.home_assistant import DiscoveryWriter
    from talaia.wire.mqtt.topic_tree import CommandTopic, TopicTree

__all__ = ["BrokerOutput", "SitePublisher"]


class BrokerOutput(Protocol):
    """The way to the broker; nothing here waits for it."""

    def set_payload(self, topic: str, payload: bytes) -> None:
        """Have a topic hold ``payload``."""
        ...

    def keep_only(self, site: str, topics: set[str]) -> None:
        """Clear every topic of a site but these."""
        ...

    def send_answer(self, topic: str, payload: bytes, correlation: bytes) -> None:
        """Tell what became of a command, to whoever hears it now."""
        ...

    def report_refused(self, message: InboundMessage, refused: RefusedMessage) -> None:
        """Write down that something was refused."""
        ...


class SitePublisher:
    """See `ClientSession`: its client is the broker."""

    def __init__(
        self,
        connection: ClientConnection,
        output: BrokerOutput,
        *,
        choice: SiteChoice,
        tree: TopicTree,
        discovery: DiscoveryWriter | None,
        every_s: float,
        clock: Clock,
    ) -> None:
        """Publish by ``output`` what ``connection`` gives its account of ``choice``."""
        self._connection = connection
        self._output = output
        self._choice = choice
        self._tree = tree
        self._discovery = discovery
        self._every_s = every_s
        self._clock = clock
        self._live = connection.live
        # Of the description that is published.
        self._edition: str | None = None
        self._publication = SitePublication()
        # By place: when the value came that was written last (monotonic ns), and how good it was.
        self._written: dict[int, tuple[int, ValueQuality]] = {}
        self._relay = CommandRelay(
            connection, clock, answer=self._answer_command, report_refused=output.report_refused
        )

    # ── to the broker ──

    async def read_client(self) -> None:
        """Publish until cancelled; what the broker sends comes by `receive_message`."""
        while True:
            self.publish_changes()
            await asyncio.sleep(self._every_s)

    def publish_changes(self) -> None:
        """Publish what is not as it was."""
        if self._live.edition != self._edition:
            self._describe_again()
        live = self._live
        if self._publication.site_state:
            self._set_state(self._publication.site_state, on=live.online)
        for device, topic in self._publication.devices.items():
            self._set_state(topic, on=is_reached(live, device))
        now_ns = self._clock.monotonic_ns()
        for channel in self._publication.channels:
            self._publish_channel(channel, now_ns)

    def _describe_again(self) -> None:
        self._edition = self._live.edition
        self._written.clear()
        self._publication = make_publication(
            self._connection.description,
            self._live.channels,
            grants=self._connection.who.grants,
            choice=self._choice,
            tree=self._tree,
            discovery=self._discovery,
        )
        self._output.keep_only(self._live.name, set(self._publication.retained_topics()))
        for topic, payload in self._publication.discovery.items():
            self._output.set_payload(topic, payload)

    def _set_state(self, topic: str, *, on: bool) -> None:
        self._output.set_payload(topic, ONLINE if on else OFFLINE)

    def _publish_channel(self, channel: PublishedChannel, now_ns: int) -> None:
        mark = reading_mark(self._live, channel, now_ns)
        if mark is None or self._written.get(channel.at) == mark:
            return
        self._written[channel.at] = mark
        reading = read_channel(self._live, channel, mark[1])
        payload = encode_value(
            reading.value, unit=channel.unit, time_us=reading.time_us, quality=reading.quality
        )
        self._output.set_payload(channel.topic, payload)

    # ── from the broker ──

    def receive_message(self, message: InboundMessage) -> None:
        """Do what a message asks, or say why not."""
        self._relay.receive_message(message, self._publication)

    def _answer_command(self, asked: CommandTopic, payload: bytes, correlation: bytes) -> None:
        if asked.command:
            topic = self._tree.command_answer(*asked)
        else:
            topic = self._tree.stop_answer(asked.site, asked.device)
        self._output.send_answer(topic, payload, correlation)

    async def deliver_message(self, message: ToBrowser) -> None:
        """Tell the broker what became of what it asked; all else is read where it stands."""
        self._relay.deliver_message(message)

    async def warn_person(self, text: str) -> None:
        """Tell nobody: nothing is driven by MQTT."""

    async def close_client(self, code: int) -> None:
        """Leave the broker's connection to the other sites."""
