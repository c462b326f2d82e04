"""What robots report: told to pages and written down."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.features.feature import Feature
from talaia.hub.live.gateways.flood_guard import FloodGuard
from talaia.hub.live.gateways.robot_events import RobotEvents

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.live.alarms.alarm_engine import AlarmEngine
    from talaia.hub.store.audit import Audit

__all__ = ["RobotEventsFeature"]


class RobotEventsFeature(Feature):
    """States and events of devices.

    Attributes:
        reporting: takes them.
        flood_guard: slows gateways that say too much.

    """

    name = "robot_events"

    def __init__(self, core: Core, *, alarms: AlarmEngine, audit: Audit) -> None:
        """Tell pages that come how ``alarms`` stand, too."""
        self.reporting = RobotEvents(
            sites=core.sites,
            browsers=core.browsers,
            alarms=alarms,
            audit=audit,
            clock=core.clock,
        )
        self.flood_guard = FloodGuard(core.sites, self.reporting, core.clock)
