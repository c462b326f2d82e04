"""The hub at a broker: connects, signs in by a token, publishes, listens, and begins again.

Long, because what a lost broker, a token that ends and a site that changes do is read together.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, NamedTuple

import aiomqtt

from talaia.hub.auth.rate_limiter import RateLimiter
from talaia.hub.clients.catalog import MQTT
from talaia.hub.clients.mqtt.broker_client import (
    connect_broker,
    read_message,
    subscribe_commands,
)
from talaia.hub.clients.mqtt.broker_settings import read_secret
from talaia.hub.clients.mqtt.site_publisher import SitePublisher
from talaia.hub.errors import StoreDown
from talaia.hub.live.first_completed import until_first
from talaia.wire.mqtt.payloads import OFFLINE, ONLINE
from talaia.wire.mqtt.topic_tree import TopicTree

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Collection

    from talaia.clock import Clock
    from talaia.hub.auth.permissions import Who
    from talaia.hub.clients.client_connection import ClientConnection, ClientConnections
    from talaia.hub.clients.mqtt.asked_commands import InboundMessage, RefusedMessage
    from talaia.hub.clients.mqtt.broker_feed import BrokerFeed
    from talaia.hub.clients.mqtt.broker_settings import BrokerSettings
    from talaia.hub.clients.open_protocols import OpenProtocols
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.store.audit import Audit
    from talaia.wire.mqtt.home_assistant import DiscoveryWriter

__all__ = ["BridgeParts", "MqttBridge"]

_LOG = logging.getLogger(__name__)
# Between two tries to connect (s): first, and at the most.
_FIRST_WAIT_S, _MOST_WAIT_S = 0.5, 30.0
# Of a farewell to a broker that does not read (s).
_FAREWELL_S = 3.0
# Commands at once, and for long (1/s).
_BURST, _PER_S = 20, 5.0
# Topics of which it was said that a retained message was refused.
_MOST_TOLD = 1000


class BridgeParts(NamedTuple):
    """What of the hub a bridge uses.

    Attributes:
        who_of_token: tells whose a token is; raises `StoreDown`.

    """

    connections: ClientConnections
    protocols: OpenProtocols
    sites: Sites
    audit: Audit
    clock: Clock
    who_of_token: Callable[[str], Awaitable[Who | None]]


class MqttBridge:
    """Keeps one broker told, for as long as an admin lets it."""

    def __init__(
        self,
        settings: BrokerSettings,
        parts: BridgeParts,
        *,
        feed: BrokerFeed,
        discovery: DiscoveryWriter | None,
        check_s: float,
    ) -> None:
        """Work by ``settings``.

        Args:
            settings: of the broker.
            parts: of the hub.
            feed: what goes to the broker.
            discovery: for Home Assistant.
            check_s: it is looked so often whether the token is good and the protocol open.

        """
        self._settings = settings
        self._parts = parts
        self._feed = feed
        self._discovery = discovery
        self._check_s = check_s
        self._broker = str(settings.broker)
        self._tree = TopicTree(settings.prefix)
        # By site: the topics that its publisher keeps; None until all have said so.
        self._kept: dict[str, set[str]] = {}
        self._complete = False
        self._publishers: dict[str, SitePublisher] = {}
        self._ending = asyncio.Event()
        self._limits = RateLimiter(_BURST, _PER_S)
        self._told_retained: set[str] = set()
        # What it was said of that it is in trouble: ``broker``, ``token``, ``flood``.
        self._troubles: set[str] = set()

    # ── connecting ──

    async def run(self) -> None:
        """Keep the broker told, until `stop_bridge` was called."""
        for result in await until_first(self._keep_connected(), self._end_late()):
            if isinstance(result, Exception):
                raise result

    async def _keep_connected(self) -> None:
        wait_s = _FIRST_WAIT_S
        while not self._ending.is_set():
            try:
                # With nobody to publish for, it is dialled only to clear what is left there.
                if await self._find_account() is None and not self._feed.holds_topics:
                    await self._pause(self._check_s)
                    continue
                async with connect_broker(self._settings.broker, self._tree) as client:
                    wait_s = _FIRST_WAIT_S
                    self._end_trouble("broker", f"the broker {self._broker} is connected again")
                    await self._serve_connection(client)
                await self._pause(self._check_s)
            except StoreDown:
                # Who may do what will be known again; until then all stays as it is.
                await self._pause(self._check_s)
            except (aiomqtt.MqttError, OSError, ValueError) as error:
                self._begin_trouble("broker", f"the broker {self._broker} is not reached: {error}")
                await self._pause(wait_s)
                wait_s = min(2 * wait_s, _MOST_WAIT_S)

    async def _end_late(self) -> None:
        """Return when the bridge was to end and has not: its broker may not answer."""
        await self._ending.wait()
        await asyncio.sleep(_FAREWELL_S + 1)

    def stop_bridge(self) -> None:
        """Have the broker told that the hub goes, and end."""
        self._ending.set()

    async def _pause(self, wait_s: float) -> None:
        try:
            async with asyncio.timeout(wait_s):
                await self._ending.wait()
        except TimeoutError:
            return

    async def _find_account(self) -> Who | None:
        """Give the account by whose rights all is done now; None: nothing is to be published.

        Raises:
            StoreDown: it cannot be told now.

        """
        if not self._parts.protocols.is_open(MQTT):
            return None
        name = self._settings.token_file
        try:
            who = await self._parts.who_of_token(await asyncio.to_thread(read_secret, name))
        except OSError as error:
            self._begin_trouble("token", f"the token in {name} cannot be read: {error.strerror}")
            return None
        if who is None:
            self._begin_trouble("token", f"the token in {name} is not good; see Account, Tokens")
        else:
            self._end_trouble("token", f"the token in {name} is good again")
        return who

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
        while not self._ending.is_set():
            try:
                who = await self._find_account()
            except StoreDown:
                self._feed.set_payload(self._tree.hub_state, OFFLINE)
                await self._pause(self._check_s)
                continue
            if who is None:
                # What may not be published any more does not stay there either.
                self._feed.send_answer(self._tree.hub_state, OFFLINE)
                self._feed.keep_only(())
                break
            await self._publish_account(client, who)
        else:
            self._feed.set_payload(self._tree.hub_state, OFFLINE)
        try:
            async with asyncio.timeout(_FAREWELL_S):
                await self._feed.wait_drained()
        except TimeoutError:
            _LOG.warning("the broker %s did not take the farewell", self._broker)

    async def _publish_account(self, client: aiomqtt.Client, who: Who) -> None:
        """Publish what an account may see, until something of that changes."""
        self._complete = False
        self._kept.clear()
        found = self._find_sites()
        connections = {live.name: self._connect_site(live, who) for live in found}
        self._publishers = {name: publisher for name, (_, publisher) in connections.items()}
        try:
            for publisher in self._publishers.values():
                publisher.publish_changes()
            # Only now is it known what is left of earlier runs and of other rights.
            self._complete = True
            self._clear_others()
            await subscribe_commands(client, self._command_filters())
            # Last: whoever sees this may send a command.
            self.set_payload(self._tree.hub_state, ONLINE)
            await until_first(
                self._ending.wait(),
                self._watch_sites(set(connections)),
                *(self._serve_site(*both) for both in connections.values()),
            )
        finally:
            self._publishers = {}
            # Nothing of an account that may have no rights any more is sent from here on.
            self._feed.withhold_values()

    def _find_sites(self) -> list[LiveSite]:
        return [live for live in self._parts.sites if live.name in self._settings.sites]

    def _connect_site(self, live: LiveSite, who: Who) -> tuple[ClientConnection, SitePublisher]:
        connection = self._parts.connections.connect(live, who, via=f"MQTT {self._broker}")
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

    async def _watch_sites(self, names: Collection[str]) -> None:
        """Return when there are other sites than these."""
        while True:
            await asyncio.sleep(self._check_s)
            if {live.name for live in self._find_sites()} != names:
                return

    def _command_filters(self) -> list[str]:
        # A site that no command is permitted of is not even listened to, but for STOP.
        filters = [self._tree.stop_filter(name) for name in self._publishers]
        return filters + [
            self._tree.command_filter(name)
            for name in self._publishers
            if self._settings.sites[name].commands
        ]

    def _clear_others(self) -> None:
        self._feed.keep_only({self._tree.hub_state}.union(*self._kept.values()))

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
        """Write down that something was refused; of what is repeated for ever, once."""
        if refused.quiet:
            if message.topic in self._told_retained or len(self._told_retained) >= _MOST_TOLD:
                return
            self._told_retained.add(message.topic)
            _LOG.warning("refused on %r: %s", message.topic, refused.why)
        self._parts.audit.append_record(
            "mqtt command refused",
            who=f"MQTT {self._broker}",
            site=message.asked.site,
            device=message.asked.device,
            message=f"{message.topic}: {refused.why}",
            good=False,
        )

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
            if inbound.asked.command and self._is_too_much():
                continue
            publisher.receive_message(inbound)

    def _is_too_much(self) -> bool:
        wait_ns = self._limits.request_turn("commands", self._parts.clock.monotonic_ns())
        if not wait_ns:
            self._end_trouble("flood", "commands by MQTT are heard again")
            return False
        self._begin_trouble("flood", f"more than {_PER_S:g} commands a second by MQTT are left out")
        return True

    def _begin_trouble(self, kind: str, text: str) -> None:
        """Say once what is wrong, until it ends."""
        if kind not in self._troubles:
            self._troubles.add(kind)
            _LOG.warning("%s", text)

    def _end_trouble(self, kind: str, text: str) -> None:
        if kind in self._troubles:
            self._troubles.discard(kind)
            _LOG.info("%s", text)
