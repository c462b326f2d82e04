"""The hub at an MQTT broker that its administrator has named."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia import __version__
from talaia.hub.clients.mqtt.bridge import BridgeParts, MqttBridge
from talaia.hub.clients.mqtt.broker_feed import BrokerFeed
from talaia.hub.clients.mqtt.broker_settings import read_broker_settings
from talaia.hub.clients.mqtt.known_topics import KnownTopics
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.wire.mqtt.home_assistant import DiscoveryWriter
from talaia.wire.mqtt.topic_tree import TopicTree

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.hub.api.access import Access
    from talaia.hub.auth.permissions import Who
    from talaia.hub.features.connections.client_protocols import ClientProtocolsFeature
    from talaia.hub.features.feature import Core
    from talaia.hub.store.audit import Audit

__all__ = ["MqttFeature"]

_KNOWN_FILE = "mqtt-topics.json"


class MqttFeature(Feature):
    """One task, where the hub was started with a file that names a broker."""

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

        async def who_of_token(token: str) -> Who | None:
            alive = await access.who_of_token(token)
            return alive.who if alive is not None else None

        parts = BridgeParts(
            connections=clients.connections,
            protocols=clients.protocols,
            sites=core.sites,
            audit=audit,
            clock=core.clock,
            who_of_token=who_of_token,
        )
        bridge = _make_bridge(core, core.settings.mqtt, parts)
        task = BackgroundTask(name="publish", run=bridge.run, stop=bridge.stop_bridge)
        self.tasks = [task]


def _make_bridge(core: Core, path: Path, parts: BridgeParts) -> MqttBridge:
    settings = read_broker_settings(path)
    tree = TopicTree(settings.prefix)
    known = KnownTopics(core.settings.data / _KNOWN_FILE)
    discovery = None
    if settings.home_assistant:
        discovery = DiscoveryWriter(settings.home_assistant, tree, __version__)
    return MqttBridge(
        settings,
        parts,
        feed=BrokerFeed(str(settings.broker), known),
        discovery=discovery,
        check_s=core.settings.check_s,
    )
