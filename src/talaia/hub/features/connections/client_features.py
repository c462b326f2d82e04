"""What serves other tools, an ordered table: one feature for each protocol of the catalog."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.features.connections.alpaca import AlpacaFeature
from talaia.hub.features.connections.foxglove import FoxgloveFeature
from talaia.hub.features.connections.metrics import MetricsFeature
from talaia.hub.features.connections.mqtt import MqttFeature
from talaia.hub.features.connections.rosbridge import RosbridgeFeature
from talaia.hub.features.connections.scripts import ScriptsFeature
from talaia.hub.features.connections.socketio import SocketioFeature

if TYPE_CHECKING:
    from talaia.hub.api.access import Access
    from talaia.hub.features.alarms import AlarmsFeature
    from talaia.hub.features.connections.client_protocols import ClientProtocolsFeature
    from talaia.hub.features.feature import Core, Feature
    from talaia.hub.features.media import MediaFeature
    from talaia.hub.files.ports import FileStore
    from talaia.hub.live.assets.robot_assets import RobotAssets
    from talaia.hub.ports import History
    from talaia.hub.store.audit import Audit

__all__ = ["build_client_features"]


def build_client_features(
    core: Core,
    *,
    clients: ClientProtocolsFeature,
    media: MediaFeature,
    alarms: AlarmsFeature,
    history: History,
    files: FileStore,
    assets: RobotAssets,
    access: Access,
    audit: Audit,
) -> tuple[Feature, ...]:
    """Build the feature of each protocol.

    Args:
        core: of the hub.
        clients: lets clients of every protocol in, and ends them.
        media: has the pictures of cameras.
        alarms: has the alarms that are counted.
        history: has past values.
        files: where whole files are.
        assets: where files of robots come from.
        access: finds the account of a token.
        audit: where it is written who did what.

    Raises:
        CannotStart: the file of a protocol's settings cannot be used.

    """
    return (
        AlpacaFeature(core, clients=clients, access=access, audit=audit),
        FoxgloveFeature(
            core, clients=clients, streams=media.streams, history=history, assets=assets
        ),
        MetricsFeature(core, clients=clients, alarms=alarms.engine, history=history, files=files),
        MqttFeature(core, clients=clients, access=access, audit=audit),
        RosbridgeFeature(core, clients=clients),
        ScriptsFeature(clients=clients),
        SocketioFeature(core, clients=clients, streams=media.streams),
    )
