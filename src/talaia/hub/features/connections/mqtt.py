"""The hub at an MQTT broker that its administrator has named."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from talaia import __version__
from talaia.hub.clients.mqtt.bridge import MqttBridge
from talaia.hub.clients.mqtt.broker_feed import BrokerFeed
from talaia.hub.clients.mqtt.broker_keeper import BridgeParts
from talaia.hub.clients.mqtt.broker_settings import read_broker_settings
from talaia.hub.clients.mqtt.known_topics import KnownTopics
from talaia.hub.clients.sparkplug.birth_numbers import BirthNumbers
from talaia.hub.clients.sparkplug.edge_node import SparkplugNode
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.wire.mqtt.home_assistant import DiscoveryWriter
from talaia.wire.mqtt.topic_tree import TopicTree

if TYPE_CHECKING:
    from talaia.hub.api.access import Access
    from talaia.hub.auth.permissions import Who
    from talaia.hub.clients.mqtt.broker_settings import BrokerSettings
    from talaia.hub.features.connections.client_protocols import ClientProtocolsFeature
    from talaia.hub.features.feature import Core
    from talaia.hub.store.audit import Audit

__all__ = ["MqttFeature"]

_BIRTHS_FILE = "sparkplug-birth"


class MqttFeature(Feature):
    """A task, where the hub was started with a file that names a broker; two with Sparkplug."""

    name = "mqtt"

    def __init__(
        self, core: Core, *, clients: ClientProtocolsFeature, access: Access, audit: Audit
    ) -> None:
        """Publish by what ``clients`` knows, for the account whose token ``access`` finds.

        Raises:
            CannotStart: the file of the settings cannot be used.

        """
        if core.settings.mqtt is None:
            return

        settings = _with_suffix(read_broker_settings(core.settings.mqtt), core.shard.suffix)
        suffix = core.shard.suffix

        async def who_of_token(token: str) -> Who | None:
            alive = await access.who_of_token(token)
            return alive.who if alive is not None else None

        parts = BridgeParts(
            connections=clients.connections,
            protocols=clients.protocols,
            presence=clients.name_broker(str(settings.broker)),
            sites=core.sites,
            has_site=core.shard.has_site,
            audit=audit,
            clock=core.clock,
            who_of_token=who_of_token,
        )
        bridge = _make_bridge(core, settings, parts)
        self.tasks = [BackgroundTask(name="publish", run=bridge.run, stop=bridge.stop_bridge)]
        if settings.sparkplug is not None:
            presence = clients.name_broker(f"{settings.broker} (Sparkplug)")
            births = BirthNumbers(core.settings.data / f"{_BIRTHS_FILE}{suffix}")
            node = SparkplugNode(
                settings,
                settings.sparkplug,
                parts._replace(presence=presence),
                births=births,
                check_s=core.settings.check_s,
            )
            task = BackgroundTask(name="publish Sparkplug", run=node.run, stop=node.stop_node)
            self.tasks.append(task)


def _with_suffix(settings: BrokerSettings, suffix: str) -> BrokerSettings:
    """Give a shard names of its own: a broker ends whoever has the name of one that comes."""
    if not suffix:
        return settings
    broker = msgspec.structs.replace(settings.broker, client_id=settings.broker.client_id + suffix)
    sparkplug = settings.sparkplug
    if sparkplug is not None:
        sparkplug = msgspec.structs.replace(sparkplug, node=sparkplug.node + suffix)
    return msgspec.structs.replace(settings, broker=broker, sparkplug=sparkplug)


def _make_bridge(core: Core, settings: BrokerSettings, parts: BridgeParts) -> MqttBridge:
    tree = TopicTree(settings.prefix, core.shard.suffix)
    # What was published by another shard is not cleared here: it may be there anew.
    known = KnownTopics(core.settings.data / f"mqtt-topics{core.shard.suffix}.json")
    discovery = None
    if settings.home_assistant:
        discovery = DiscoveryWriter(settings.home_assistant, tree, __version__)
    return MqttBridge(
        settings,
        parts,
        feed=BrokerFeed(str(settings.broker), known),
        tree=tree,
        discovery=discovery,
        check_s=core.settings.check_s,
    )
