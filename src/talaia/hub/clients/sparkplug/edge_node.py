"""The hub as an edge node of Sparkplug B: births, deaths, data, and commands.

By the Eclipse Sparkplug specification 3.0. It has a connection of its own, since its last will is
its death, and Sparkplug's messages are never retained.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from talaia.first_completed import until_first
from talaia.hub.clients.catalog import MQTT
from talaia.hub.clients.mqtt.broker_client import connect_broker, subscribe_commands
from talaia.hub.clients.mqtt.broker_keeper import FAREWELL_S, BrokerKeeper
from talaia.hub.clients.sparkplug.device_metrics import STOP_METRIC
from talaia.hub.clients.sparkplug.site_metrics import SiteMetrics
from talaia.hub.errors import StoreDown
from talaia.wire.errors import PeerError
from talaia.wire.sparkplug.payloads import (
    SparkplugMetric,
    SparkplugType,
    decode_sparkplug,
    encode_sparkplug,
)
from talaia.wire.sparkplug.topics import SparkplugKind, SparkplugTopics

if TYPE_CHECKING:
    import aiomqtt

    from talaia.hub.auth.permissions import Who
    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.hub.clients.mqtt.broker_keeper import BridgeParts
    from talaia.hub.clients.mqtt.broker_settings import BrokerSettings, SparkplugChoice
    from talaia.hub.clients.sparkplug.birth_numbers import BirthNumbers
    from talaia.hub.clients.sparkplug.device_metrics import DeviceMetrics
    from talaia.hub.live.sites import LiveSite
    from talaia.wire.sparkplug.payloads import ReadMetric, SparkplugPayload

__all__ = ["SparkplugNode"]

_LOG = logging.getLogger(__name__)
_NUMBERS = 256
_REBIRTH = "Node Control/Rebirth"


class SparkplugNode:
    """Keeps one broker told, for as long as an admin lets it."""

    def __init__(
        self,
        settings: BrokerSettings,
        choice: SparkplugChoice,
        parts: BridgeParts,
        *,
        births: BirthNumbers,
        check_s: float,
    ) -> None:
        """Work by ``settings``.

        Args:
            settings: of the broker.
            choice: the names of group and edge node.
            parts: of the hub.
            births: numbers the connections.
            check_s: it is looked so often whether the token is good and the protocol open.

        """
        self._settings = settings
        self._parts = parts
        self._births = births
        self._keeper = BrokerKeeper(settings, parts, via="Sparkplug", check_s=check_s)
        self._topics = SparkplugTopics(choice.group, choice.node)
        self._sites: dict[str, SiteMetrics] = {}
        # Of this connection.
        self._birth = 0
        # Of the next message.
        self._seq = 0
        # A host has asked for all births, or something is to be told before its time.
        self._asked_rebirth = False
        self._wake = asyncio.Event()

    async def run(self) -> None:
        """Keep the broker told, until `stop_node` was called."""
        await self._keeper.keep_connected(
            connect=self._connect, serve=self._serve_connection, has_duties=lambda: False
        )

    def stop_node(self) -> None:
        """Have the broker told that the edge node dies, and end."""
        self._keeper.ending.set()
        self._wake.set()

    def _connect(self) -> aiomqtt.Client:
        self._birth = self._births.next_number()
        death = encode_sparkplug([self._birth_metric()], time_ms=self._now_ms(), seq=None)
        return connect_broker(
            self._settings.broker,
            will=(self._topics.of_node(SparkplugKind.NODE_DEATH), death, False),
            report_refusal=self._keeper.report_refusal,
            more_id="-sparkplug",
        )

    async def _serve_connection(self, client: aiomqtt.Client) -> None:
        for result in await until_first(self._receive_messages(client), self._publish_all(client)):
            if isinstance(result, Exception):
                raise result

    # ── publishing ──

    async def _publish_all(self, client: aiomqtt.Client) -> None:
        """Publish for as long as somebody may, then die."""
        while not self._keeper.ending.is_set():
            try:
                who = await self._keeper.find_account()
            except StoreDown:
                await self._keeper.wait_turn()
                continue
            if who is None:
                break
            await self._publish_account(client, who)
        try:
            async with asyncio.timeout(FAREWELL_S):
                death = encode_sparkplug([self._birth_metric()], time_ms=self._now_ms(), seq=None)
                topic = self._topics.of_node(SparkplugKind.NODE_DEATH)
                await client.publish(topic, death, qos=1)
        except TimeoutError:
            _LOG.warning("the broker %s did not take the farewell", self._settings.broker)

    async def _publish_account(self, client: aiomqtt.Client, who: Who) -> None:
        """Publish what an account may see, until something of that changes."""
        connections = {
            live.name: self._connect_site(live, who) for live in self._keeper.find_sites()
        }
        self._sites = {name: site for name, (_, site) in connections.items()}
        try:
            await subscribe_commands(
                client,
                [
                    self._topics.of_node(SparkplugKind.NODE_COMMAND),
                    self._topics.of_device(SparkplugKind.DEVICE_COMMAND, "+"),
                ],
                report_refusal=self._keeper.report_refusal,
            )
            results = await until_first(
                self._keeper.ending.wait(),
                self._keeper.watch_sites(set(connections)),
                self._publish_changes(client),
                *(self._serve_site(*both) for both in connections.values()),
            )
            for result in results:
                if isinstance(result, Exception):
                    raise result
        finally:
            # Nothing of an account that may have no rights any more is sent from here on.
            self._sites = {}

    def _connect_site(self, live: LiveSite, who: Who) -> tuple[ClientConnection, SiteMetrics]:
        connection = self._parts.connections.connect(live, who, via=self._keeper.name)
        site = SiteMetrics(
            connection,
            choice=self._settings.sites[live.name],
            report_refused=self._keeper.report_refused,
            clock=self._parts.clock,
        )
        return connection, site

    async def _serve_site(self, connection: ClientConnection, site: SiteMetrics) -> None:
        with self._parts.protocols.count_client(MQTT, connection, None):
            await connection.serve_client(site)

    async def _publish_changes(self, client: aiomqtt.Client) -> None:
        """Tell births first, then what changes; one after the other, so that numbers rise."""
        self._asked_rebirth = True
        while True:
            self._wake.clear()
            if self._asked_rebirth or any(site.is_outdated for site in self._sites.values()):
                self._asked_rebirth = False
                await self._publish_births(client)
            for site in self._sites.values():
                for device in site.devices.values():
                    await self._publish_device(client, device)
            try:
                async with asyncio.timeout(self._settings.every_s):
                    await self._wake.wait()
            except TimeoutError:
                continue

    async def _publish_births(self, client: aiomqtt.Client) -> None:
        """Publish the birth of the edge node; all its devices are to be born after it."""
        self._seq = 0
        now_ms = self._now_ms()
        rebirth = SparkplugMetric(False, SparkplugType.BOOLEAN, now_ms, _REBIRTH)  # noqa: FBT003
        first_alias = 1
        for site in self._sites.values():
            first_alias = site.describe(first_alias)
        topic = self._topics.of_node(SparkplugKind.NODE_BIRTH)
        await self._publish(client, topic, [self._birth_metric(), rebirth])

    async def _publish_device(self, client: aiomqtt.Client, device: DeviceMetrics) -> None:
        now_ns, now_ms = self._parts.clock.monotonic_ns(), self._now_ms()
        if not device.is_reached:
            if device.born:
                device.born = False
                await self._publish_of(client, SparkplugKind.DEVICE_DEATH, device, [])
        elif not device.born:
            metrics = device.describe_birth(now_ns, now_ms)
            await self._publish_of(client, SparkplugKind.DEVICE_BIRTH, device, metrics)
        elif changes := device.list_changes(now_ns, now_ms):
            await self._publish_of(client, SparkplugKind.DEVICE_DATA, device, changes)

    async def _publish_of(
        self,
        client: aiomqtt.Client,
        kind: SparkplugKind,
        device: DeviceMetrics,
        metrics: list[SparkplugMetric],
    ) -> None:
        await self._publish(client, self._topics.of_device(kind, device.name), metrics)

    async def _publish(
        self, client: aiomqtt.Client, topic: str, metrics: list[SparkplugMetric]
    ) -> None:
        payload = encode_sparkplug(metrics, time_ms=self._now_ms(), seq=self._seq)
        self._seq = (self._seq + 1) % _NUMBERS
        await client.publish(topic, payload, qos=0)

    def _birth_metric(self) -> SparkplugMetric:
        return SparkplugMetric(self._birth, SparkplugType.INT_64, self._now_ms(), "bdSeq")

    def _now_ms(self) -> int:
        return self._parts.clock.wall_ns() // 1_000_000

    # ── listening ──

    async def _receive_messages(self, client: aiomqtt.Client) -> None:
        async for message in client.messages:
            topic = str(message.topic)
            name = self._topics.commanded_device(topic)
            if name is None:
                continue
            try:
                payload = decode_sparkplug(message.payload)
            except PeerError:
                # Nobody can be told: Sparkplug's commands have no answers.
                continue
            if not name:
                self._receive_node_command(payload, retained=bool(message.retain))
            else:
                self._receive_device_command(topic, name, payload, retained=bool(message.retain))

    def _receive_node_command(self, payload: SparkplugPayload, *, retained: bool) -> None:
        wanted = any(metric.name == _REBIRTH and metric.value for metric in payload.metrics)
        if wanted and not retained and not self._keeper.is_too_much():
            self._asked_rebirth = True
            self._wake.set()

    def _receive_device_command(
        self, topic: str, name: str, payload: SparkplugPayload, *, retained: bool
    ) -> None:
        site = self._sites.get(name.partition(".")[0])
        device = site.devices.get(name) if site is not None else None
        if site is None or device is None:
            return
        for metric in payload.metrics:
            # STOP is never too much.
            if metric.name != STOP_METRIC and self._keeper.is_too_much():
                continue
            site.write_metric(topic, device, _with_time(metric, payload), retained=retained)
        self._wake.set()


def _with_time(metric: ReadMetric, payload: SparkplugPayload) -> ReadMetric:
    """Give a metric with the older of its own time and its message's."""
    known = [time_ms for time_ms in (metric.time_ms, payload.time_ms) if time_ms is not None]
    return metric._replace(time_ms=min(known, default=None))
