"""Nights: proposals and requests, what gateways observe of them, and who lets it happen."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.observing.group_lookup import GroupLookup
from talaia.hub.api.observing.group_steps import GroupStepPages
from talaia.hub.api.observing.nights import NightPages
from talaia.hub.api.observing.observed_frames import ObservedFramePages
from talaia.hub.api.observing.outlooks import OutlookPages
from talaia.hub.api.observing.proposals import ProposalPages
from talaia.hub.api.observing.request_groups import RequestPages
from talaia.hub.api.observing.short_nights import ShortNightPages
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.live.observing.forecast_service import ForecastService
from talaia.hub.live.observing.night_board import NightBoard
from talaia.hub.live.observing.night_link import NightLink
from talaia.hub.live.observing.night_notifier import NightNotifier
from talaia.hub.live.observing.observation_intake import ObservationIntake
from talaia.hub.live.observing.outlook_service import OutlookService
from talaia.hub.live.observing.request_sender import RequestSender
from talaia.hub.store.observing.observations import ObservationStore
from talaia.hub.store.observing.proposals import ProposalStore
from talaia.hub.store.observing.request_store import RequestStore

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.hub.archive.store import Archive
    from talaia.hub.features.feature import Core
    from talaia.hub.store.audit import Audit

__all__ = ["ObservingFeature"]


class ObservingFeature(Feature):
    """What is asked of the nights of every site, and what becomes of it.

    Attributes:
        board: how the nights stand; greets pages.
        link: what gateways say of their nights is led here.
        proposals, requests: what is kept.
        sender: tells gateways what has changed.

    """

    name = "observing"

    def __init__(
        self, core: Core, *, deliver: Callable[[], None], archive: Archive, audit: Audit
    ) -> None:
        """Write down in ``audit`` what people do and how requests end.

        ``deliver``: there may be something in the outbox of messages. ``archive``: has pictures.
        """
        database, clock, simulated = core.database, core.clock, core.settings.simulated_sites
        self.proposals = ProposalStore(database, clock)
        self.requests = RequestStore(database, clock, core.shard.own_rows)
        observations = ObservationStore(database, clock)
        self.board = NightBoard(core.sites, core.browsers, clock)
        sender = self.sender = RequestSender(core.sites, self.requests, self.proposals)
        intake = ObservationIntake(
            observations=observations,
            requests=self.requests,
            news=self.board,
            resend=sender.requests_changed,
            deliver=deliver,
            audit=audit,
        )
        notifier = NightNotifier(database, clock, deliver)
        self.link = NightLink(board=self.board, sender=sender, intake=intake, notifier=notifier)
        forecasts = ForecastService(self.requests, self.proposals, clock)
        lookup = GroupLookup(self.proposals, self.requests)
        pages = (
            ProposalPages(self.proposals, sender, audit),
            RequestPages(
                proposals=self.proposals,
                requests=self.requests,
                observations=observations,
                lookup=lookup,
                board=self.board,
                news=sender,
                audit=audit,
                clock=clock,
            ),
            GroupStepPages(
                requests=self.requests, lookup=lookup, news=sender, audit=audit, clock=clock
            ),
            OutlookPages(
                outlooks=OutlookService(clock),
                forecasts=forecasts,
                proposals=self.proposals,
                requests=self.requests,
                lookup=lookup,
            ),
            ObservedFramePages(
                archive=archive,
                observations=observations,
                proposals=self.proposals,
                requests=self.requests,
                lookup=lookup,
            ),
            ShortNightPages(
                simulated=simulated,
                proposals=self.proposals,
                requests=self.requests,
                board=self.board,
                news=sender,
                audit=audit,
                clock=clock,
            ),
            NightPages(
                board=self.board,
                proposals=self.proposals,
                requests=self.requests,
                simulated=simulated,
                audit=audit,
                clock=clock,
            ),
        )
        self.routers = [page.make_router() for page in pages]
        self.tasks = [
            BackgroundTask(name="send", run=sender.run),
            BackgroundTask(name="keep", run=intake.run),
            BackgroundTask(name="expire", run=intake.expire_requests),
            BackgroundTask(name="notify", run=notifier.run),
            BackgroundTask(name="forecast", run=forecasts.run),
        ]
