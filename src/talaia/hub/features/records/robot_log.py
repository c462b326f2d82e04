"""The robots' own logs: lines that gateways heard on ``/rosout``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.records.robot_log import RobotLogPages
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.live.robot_log_intake import RobotLogIntake
from talaia.hub.store.sites.robot_log import RobotLogStore

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core

__all__ = ["RobotLogFeature"]


class RobotLogFeature(Feature):
    """Keeps lines, and finds them.

    Attributes:
        intake: takes them from gateways.

    """

    name = "robot_log"

    def __init__(self, core: Core) -> None:
        """Keep them in the hub's database, for as long as its settings say."""
        settings = core.settings
        store = RobotLogStore(core.database, core.clock, own=core.shard.own_rows)
        self.intake = RobotLogIntake(
            store, core.clock, days=settings.robot_log_days, most=settings.robot_log_most
        )
        self.routers = [RobotLogPages(store).make_router()]
        self.tasks = [BackgroundTask(name="keep", run=self.intake.run)]
