"""Notices of transients: from a folder or by a token, to rapid requests by proposals' rules."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.observing.admission import GroupAdmission
from talaia.hub.api.observing.alert_notices import AlertPages
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.live.observing.alert_folder import AlertFolder
from talaia.hub.live.observing.alert_intake import AlertIntake
from talaia.hub.live.observing.notice_readers import NoticeReaders
from talaia.hub.store.observing.alert_store import AlertStore

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.features.nights.observing import ObservingFeature
    from talaia.hub.store.audit import Audit

__all__ = ["AlertNoticesFeature"]


class AlertNoticesFeature(Feature):
    """Routes of rules and notices, and a task where the hub was started with a folder.

    Attributes:
        intake: acts upon notices.

    """

    name = "alert_notices"

    def __init__(self, core: Core, *, observing: ObservingFeature, audit: Audit) -> None:
        """Ask for requests in what ``observing`` keeps."""
        alerts = AlertStore(core.database, core.clock)
        self.intake = AlertIntake(
            alerts=alerts,
            proposals=observing.proposals,
            requests=observing.requests,
            admission=GroupAdmission,
            news=observing.sender,
            audit=audit,
            clock=core.clock,
        )
        pages = AlertPages(
            alerts=alerts, proposals=observing.proposals, intake=self.intake, audit=audit
        )
        self.routers = [pages.make_router()]
        if core.settings.alerts is not None:
            readers = None
            if core.seat is not None and core.seat.plan.names:
                readers = NoticeReaders(core.shard.name, core.seat.plan.all_names)
            folder = AlertFolder(core.settings.alerts, core.sites, self.intake, readers)
            self.tasks = [BackgroundTask(name="read notices", run=folder.run)]
