"""The hub at a broker: publishes what an account may see, and listens to commands."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from talaia.first_completed import until_first
from talaia.hub.clients.catalog import MQTT
from talaia.hub.clients.mqtt.broker_client import (
    connect_broker,
    read_message,
    subscribe_commands,
)
from talaia.hub.clients.mqtt.broker_keeper import FAREWELL_S, BrokerKeeper
from talaia.hub.clients.mqtt.site_publisher import SitePublisher
from talaia.hub.errors import StoreDown
from talaia.wire.mqtt.payloads import OFFLINE, ONLINE

if TYPE_CHECKING:
    from collections.abc import Collection

    import aiomqtt

    from talaia.hub.auth.permissions import Who
    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.clients.mqtt.asked_commands import InboundMessage, RefusedMessage
    from talaia.hub.clients.mqtt.broker_feed import BrokerFeed
    from talaia.hub.clients.mqtt.broker_keeper import BridgeParts
    from talaia.hub.clients.mqtt.broker_settings import BrokerSettings
    from talaia.hub.live.sites import LiveSite
    from talaia.wire.mqtt.home_assistant import DiscoveryWriter
    from talaia.wire.mqtt.topic_tree import TopicTree

__all__ = ["MqttBridge"]

_LOG = logging.getLogger(__name__)


class MqttBridge:
    """Keeps one broker told, for as long as an admin lets it."""

    def __init__(
        self,
        settings: BrokerSettings,
        parts: BridgeParts,
        *,
        feed: BrokerFeed,
        tree: TopicTree,
        discovery: DiscoveryWriter | None,
        check_s: float,
    ) -> None:
        """Work by ``settings``.

        Args:
            settings: of the broker.
            parts: of the hub.
            feed: what goes to the broker.
            tree: names the topics.
            discovery: for Home Assistant.
            check_s: it is looked so often whether the token is good and the protocol open.

        """
        self._settings = settings
        self._parts = parts
        self._feed = feed
        self._discovery = discovery
        self._broker = str(settings.broker)
        self._keeper = BrokerKeeper(settings, parts, via="MQTT", check_s=check_s)
        self._tree = tree
        # By site: the topics that its publisher keeps; None until all have said so.
        self._kept: dict[str, set[str]] = {}
        self._complete = False
        self._publishers: dict[str, SitePublisher] = {}

    # ── connecting ──

    async def run(self) -> None:
        """Keep the broker told, until `stop_bridge` was called."""
        await self._keeper.keep_connected(
            connect=self._connect,
            serve=self._serve_connection,
            # With nobody to publish for, it is dialled only to clear what is left there.
            has_duties=lambda: self._feed.holds_topics,
        )

    def stop_bridge(self) -> None:
        """Have the broker told that the hub goes, and end."""
        self._keeper.ending.set()

    def _connect(self) -> aiomqtt.Client:
        return connect_broker(
            self._settings.broker,
            will=(self._tree.hub_state, OFFLINE, True),
            report_refusal=self._keeper.report_refusal,
        )

    async def _serve_connection(self, client: aiomqtt.Client) -> None:
        self._feed.restart_connection()
        results = await until_first(
            self._feed.send_due(client), self._receive_messages(client), self._publish_all(client)
        )
        for result in results:
            if isinstance(result, Exception):
                raise result

    # ── publishing ──

    async def _publish_all(self, client: aiomqtt.Client) -> None:
        """Publish for as long as somebody may, then leave the broker as it should be."""
        while not self._keeper.ending.is_set():
            try:
                who = await self._keeper.find_account()
            except StoreDown:
                self._feed.set_payload(self._tree.hub_state, OFFLINE)
                await self._keeper.wait_turn()
                continue
            if who is None:
                # What may not be published any more does not stay there either.
                self._feed.send_answer(self._tree.hub_state, OFFLINE)
                self._keep_only(())
                break
            await self._publish_account(client, who)
        else:
            self._feed.set_payload(self._tree.hub_state, OFFLINE)
        try:
            async with asyncio.timeout(FAREWELL_S):
                await self._feed.wait_drained()
        except TimeoutError:
            _LOG.warning("the broker %s did not take the farewell", self._broker)

    async def _publish_account(self, client: aiomqtt.Client, who: Who) -> None:
        """Publish what an account may see, until something of that changes."""
        self._complete = False
        self._kept.clear()
        found = self._keeper.find_sites()
        connections = {live.name: self._connect_site(live, who) for live in found}
        self._publishers = {name: publisher for name, (_, publisher) in connections.items()}
        try:
            for publisher in self._publishers.values():
                publisher.publish_changes()
            # Only now is it known what is left of earlier runs and of other rights.
            self._complete = True
            self._clear_others()
            await subscribe_commands(
                client, self._command_filters(), report_refusal=self._keeper.report_refusal
            )
            # Last: whoever sees this may send a command.
            self.set_payload(self._tree.hub_state, ONLINE)
            await until_first(
                self._keeper.ending.wait(),
                self._keeper.watch_sites(set(connections)),
                *(self._serve_site(*both) for both in connections.values()),
            )
        finally:
            self._publishers = {}
            # Nothing of an account that may have no rights any more is sent from here on.
            self._feed.withhold_values()

    def _connect_site(self, live: LiveSite, who: Who) -> tuple[ClientConnection, SitePublisher]:
        connection = self._parts.connections.connect(live, who, via=self._keeper.name)
        publisher = SitePublisher(
            connection,
            self,
            choice=self._settings.sites[live.name],
            tree=self._tree,
            discovery=self._discovery,
            every_s=self._settings.every_s,
            clock=self._parts.clock,
        )
        return connection, publisher

    async def _serve_site(self, connection: ClientConnection, publisher: SitePublisher) -> None:
        with self._parts.protocols.count_client(MQTT, connection, None):
            await connection.serve_client(publisher)

    def _command_filters(self) -> list[str]:
        # A site that no command is permitted of is not even listened to, but for STOP.
        filters = [self._tree.stop_filter(name) for name in self._publishers]
        return filters + [
            self._tree.command_filter(name)
            for name in self._publishers
            if self._settings.sites[name].commands
        ]

    def _clear_others(self) -> None:
        self._keep_only({self._tree.hub_state}.union(*self._kept.values()))

    def _keep_only(self, topics: Collection[str]) -> None:
        # Of sites that another shard has by now: it has published them anew.
        elsewhere = [name for name in self._settings.sites if not self._parts.has_site(name)]
        self._feed.forget_topics(
            [
                topic
                for topic in self._feed.known_topics
                for name in elsewhere
                if self._is_about(topic, name)
            ]
        )
        self._feed.keep_only(topics)

    def _is_about(self, topic: str, site: str) -> bool:
        if self._discovery is not None and self._discovery.is_about(topic, site):
            return True
        return self._tree.is_about(topic, site)

    # ── an output, see `BrokerOutput` ──

    def set_payload(self, topic: str, payload: bytes) -> None:
        """Have a topic hold ``payload``."""
        self._feed.set_payload(topic, payload)

    def keep_only(self, site: str, topics: set[str]) -> None:
        """Clear every topic of a site but these."""
        self._kept[site] = topics
        if self._complete:
            self._clear_others()

    def send_answer(self, topic: str, payload: bytes, correlation: bytes) -> None:
        """Tell what became of a command."""
        self._feed.send_answer(topic, payload, correlation)

    def report_refused(self, message: InboundMessage, refused: RefusedMessage) -> None:
        """Write down that something was refused."""
        self._keeper.report_refused(message, refused)

    # ── listening ──

    async def _receive_messages(self, client: aiomqtt.Client) -> None:
        async for message in client.messages:
            inbound = read_message(message, self._tree)
            if inbound is None:
                continue
            publisher = self._publishers.get(inbound.asked.site)
            if publisher is None:
                continue
            # STOP is never too much.
            if inbound.asked.command and self._keeper.is_too_much():
                continue
            publisher.receive_message(inbound)
