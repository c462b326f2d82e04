"""Metrics: what Prometheus scrapes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.clients.metrics_route import MetricsRoute
from talaia.hub.features.feature import Feature

if TYPE_CHECKING:
    from talaia.hub.features.connections.client_protocols import ClientProtocolsFeature
    from talaia.hub.features.feature import Core
    from talaia.hub.live.alarms.alarm_engine import AlarmEngine

__all__ = ["MetricsFeature"]


class MetricsFeature(Feature):
    """One route, beside those of the client protocols, for its clients keep no connection."""

    name = "metrics"

    def __init__(self, core: Core, *, clients: ClientProtocolsFeature, alarms: AlarmEngine) -> None:
        """Let in whom ``clients`` lets in."""
        route = MetricsRoute(
            admission=clients.admission,
            protocols=clients.protocols,
            sites=core.sites,
            browsers=core.browsers,
            alarms_of=alarms.alarms_of,
            clock=core.clock,
        )
        self.routers = [route.router()]
