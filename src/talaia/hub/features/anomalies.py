"""Anomalies: detectors at work on what comes in."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.causes.cause_pages import CausePages
from talaia.hub.api.sites.alarm_budgets import AlarmBudgetPages
from talaia.hub.api.sites.anomalies import AnomalyPages
from talaia.hub.api.sites.back_tests import BackTestPages
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.live.detection.alarm_budget import AlarmBudgets
from talaia.hub.live.detection.anomaly_service import AnomalyService
from talaia.hub.live.detection.back_test import BackTests
from talaia.hub.live.detection.common_causes import CommonCauses
from talaia.hub.store.sites.detector_state import DetectorState

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.live.alarms.alarm_engine import AlarmEngine
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.ports import History
    from talaia.hub.store.audit import Audit

__all__ = ["AnomaliesFeature"]


class AnomaliesFeature(Feature):
    """The detectors that site descriptions ask for.

    Attributes:
        detectors: runs them.
        causes: gathers what they say into episodes of one cause.
        budgets: sets their thresholds for so many false alarms.

    """

    name = "anomalies"

    def __init__(
        self,
        core: Core,
        *,
        history: History,
        reporting: RobotEvents,
        alarms: AlarmEngine,
        audit: Audit,
    ) -> None:
        """Keep scores in ``history``; what is found goes to ``reporting`` and ``alarms``."""
        self.detectors = AnomalyService(
            sites=core.sites,
            history=history,
            learned=DetectorState(core.database, core.clock),
            fanout=core.fanout,
            clock=core.clock,
        )
        self.causes = CommonCauses(
            sites=core.sites,
            detectors=self.detectors,
            events=reporting,
            alarms=alarms,
            learned=DetectorState(core.database, core.clock),
            clock=core.clock,
        )
        # In this order: an anomaly is in the log before an alarm is raised by it.
        self.detectors.add_listener(self.causes)
        self.detectors.add_listener(alarms)
        self.detectors.add_display(reporting)
        pages = AnomalyPages(
            watching=self.detectors, history=history, audit=audit, clock=core.clock
        )
        self.budgets = AlarmBudgets(
            self.detectors,
            sites=core.sites,
            history=history,
            learned=DetectorState(core.database, core.clock),
            clock=core.clock,
        )
        budgets = AlarmBudgetPages(self.budgets, self.detectors, audit)
        causes = CausePages(watching=self.detectors, history=history, audit=audit, clock=core.clock)
        self._tests = BackTests(history)
        tests = BackTestPages(self._tests, core.clock)
        self.routers = [
            pages.make_router(),
            budgets.make_router(),
            causes.make_router(),
            tests.make_router(),
        ]
        self.tasks = [
            BackgroundTask(name="detect", run=self.detectors.run),
            BackgroundTask(name="causes", run=self.causes.run),
            BackgroundTask(name="false alarms", run=self.budgets.run),
            BackgroundTask(name="false alarms of the past", run=self.budgets.read_past),
        ]

    async def open(self) -> None:
        """Bring back which anomalies were open."""
        await self.causes.open()

    async def close(self) -> None:
        """Write down what detectors have learned."""
        await self.causes.close()
        await self._tests.close()
        await self.budgets.close()
        await self.detectors.close()
