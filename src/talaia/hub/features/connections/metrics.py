"""Metrics: what Prometheus scrapes, and past values that it asks for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.clients.metrics_route import MetricsRoute
from talaia.hub.api.clients.remote_read_route import RemoteReadRoute
from talaia.hub.features.feature import Feature

if TYPE_CHECKING:
    from talaia.hub.features.connections.client_protocols import ClientProtocolsFeature
    from talaia.hub.features.feature import Core
    from talaia.hub.files.ports import FileStore
    from talaia.hub.live.alarms.alarm_engine import AlarmEngine
    from talaia.hub.ports import History

__all__ = ["MetricsFeature"]


class MetricsFeature(Feature):
    """Two routes, beside those of the client protocols, for its clients keep no connection."""

    name = "metrics"

    def __init__(
        self,
        core: Core,
        *,
        clients: ClientProtocolsFeature,
        alarms: AlarmEngine,
        history: History,
        files: FileStore,
    ) -> None:
        """Give figures of now from the parts of the hub, past ones from ``history``.

        Of ``files`` it tells whether they can be read and written.
        """
        route = MetricsRoute(
            protocols=clients.protocols,
            sites=core.sites,
            browsers=core.browsers,
            alarms_of=alarms.alarms_of,
            clock=core.clock,
            seat=core.seat,
            files=files,
        )
        past = RemoteReadRoute(sites=core.sites, history=history)
        self.routers = [route.router(), past.router()]
