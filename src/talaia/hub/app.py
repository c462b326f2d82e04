"""The hub put together: the one place where its parts are built."""

from __future__ import annotations

import asyncio
import functools
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from fastapi import Depends, FastAPI

from talaia.hub.api.access import Access
from talaia.hub.api.account_parts import AccountParts
from talaia.hub.api.accounts import Accounts
from talaia.hub.api.alarms import AlarmPages
from talaia.hub.api.anomalies import AnomalyPages
from talaia.hub.api.archive import ArchivePages
from talaia.hub.api.audit import AuditPages
from talaia.hub.api.descriptions import DescriptionPages
from talaia.hub.api.gateways import GatewayPages, Proof
from talaia.hub.api.history import HistoryPages
from talaia.hub.api.limits import Limits
from talaia.hub.api.notify import NotifyPages
from talaia.hub.api.openapi import ApiDescription
from talaia.hub.api.own import OwnPages
from talaia.hub.api.pages import Pages
from talaia.hub.api.people import PeoplePages
from talaia.hub.api.problems import answer_problems
from talaia.hub.api.proving import Proving
from talaia.hub.api.recordings import RecordingPages
from talaia.hub.api.roles import RolePages
from talaia.hub.api.shield import Shield
from talaia.hub.api.sightings import SightingPages
from talaia.hub.api.sites import SitePages
from talaia.hub.api.sky import SkyPages
from talaia.hub.api.sockets import Sockets
from talaia.hub.api.storage import StoragePages
from talaia.hub.api.tokens import TokenPages
from talaia.hub.archive.store import Archive
from talaia.hub.auth.passwords import Passwords
from talaia.hub.auth.seal import SEAL_FILE, seal_of
from talaia.hub.auth.throttle import Throttle
from talaia.hub.certificate import certificate_of, fingerprint, key_hash
from talaia.hub.history.limits import Limits as HistoryLimits
from talaia.hub.history.parcel import FOLDER as IMPORTS
from talaia.hub.history.store import HistoryStore
from talaia.hub.live.admission import Admission
from talaia.hub.live.alarms import Alarms
from talaia.hub.live.browsers import Browsers
from talaia.hub.live.changes import Changes
from talaia.hub.live.commanding import Commanding
from talaia.hub.live.describing import Describing
from talaia.hub.live.detecting import MODELS, Detecting, Places
from talaia.hub.live.fanout import Fanout
from talaia.hub.live.gate import Gate
from talaia.hub.live.gateways import Gateways
from talaia.hub.live.inbox import Inbox
from talaia.hub.live.known import KnownSites
from talaia.hub.live.links import Links
from talaia.hub.live.media import Media
from talaia.hub.live.parts import Parts
from talaia.hub.live.pictures import PictureKeeper
from talaia.hub.live.recordings import Recordings
from talaia.hub.live.reporting import Reporting
from talaia.hub.live.seats import Seats
from talaia.hub.live.sightings import Sightings
from talaia.hub.live.sites import Sites
from talaia.hub.live.uploads import Uploads
from talaia.hub.live.watching import Watching
from talaia.hub.notify.delivering import Delivering
from talaia.hub.notify.sending import Sender
from talaia.hub.store.alarms import AlarmStore
from talaia.hub.store.audit import Audit
from talaia.hub.store.browsers import KnownBrowsers
from talaia.hub.store.database import Database
from talaia.hub.store.descriptions import Descriptions
from talaia.hub.store.enrolment import Enrolment
from talaia.hub.store.factors import Factors
from talaia.hub.store.learned import Learned
from talaia.hub.store.notices import Notices
from talaia.hub.store.notify import NotifyStore
from talaia.hub.store.people import People
from talaia.hub.store.recordings import RecordingList
from talaia.hub.store.register import Register
from talaia.hub.store.roles import Roles
from talaia.hub.store.roster import Roster
from talaia.hub.store.sessions import Sessions
from talaia.hub.store.sightings import SightingStore
from talaia.hub.store.sites import SiteRegistry
from talaia.hub.store.tokens import ApiTokens
from talaia.hub.store.tries import Tries
from talaia.objects.worker import Worker
from talaia.web import static_dir

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from starlette.types import ASGIApp

    from talaia.clock import Clock
    from talaia.hub.ports import History
    from talaia.hub.settings import Settings

__all__ = ["Hub", "build"]


class Hub:
    """A hub that is put together. Serve `asgi`; it starts and ends with the server's lifespan.

    Attributes:
        browsers: the pages that are connected now.
        fanout: who of them gets which live values.
        alarms: every alarm of every site; it is the `AnomalySink` and `SightingSink`
            that detectors speak to.
        sightings: what cameras have seen.
        setup_token: opens the set-up page; set after the start when there are no people yet.

    """

    def __init__(self, settings: Settings, clock: Clock, history: History | None = None) -> None:
        """Build every part; nothing is opened yet."""
        self.settings = settings
        self.setup_token: str | None = None
        self._clock = clock
        self._database = Database(settings.url)
        self._history = history or HistoryStore(
            settings.url, clock, HistoryLimits(bytes=settings.history_bytes)
        )
        self._people = People(self._database, clock)
        self._registry = SiteRegistry(self._database, clock)
        self._audit = Audit(self._database, clock)
        self._sessions = Sessions(self._database, clock, settings)
        self._tokens = ApiTokens(self._database, clock)
        self._seal = functools.cache(lambda: seal_of(settings.data / SEAL_FILE))
        self._factors = Factors(self._database, clock, self._seal)
        self._passwords = Passwords(settings.password_cost)
        self._known = KnownBrowsers(self._database, clock)
        self._throttle = Throttle()
        self._tries = Tries(self._database, clock, self._throttle)
        self._sites = Sites()
        self._archive = Archive(self._database, settings.data / "archive")
        pictures = PictureKeeper(self._sites, self._archive, self._audit)
        self._uploads = Uploads(settings.data / "uploads", {"fits": pictures}, settings.file_bytes)
        self._seats = Seats(Register(self._sessions, self._tokens), clock, settings)
        self._links = Links(self._sites, self._registry)
        self._descriptions = Descriptions(self._database, clock)
        self._changes = Changes(self._registry)
        self.browsers = Browsers()
        self.fanout = Fanout(self._sites, clock)
        self._media = Media(self._sites, clock, settings.linger_s)
        self._recordings = Recordings(
            RecordingList(self._database), self._audit, settings.data, settings.recordings_bytes
        )
        self._watching = Watching(
            self._sites, self._history, Learned(self._database, clock), self.fanout, clock
        )
        notices = Notices(self._database)
        self._alarm_store = AlarmStore(self._database)
        self.alarms = Alarms(self._sites, self.browsers, self._alarm_store, notices, clock)
        self._known_sites = KnownSites(
            self._sites, self._registry, self._history, self.alarms, self._audit, clock
        )
        self._inbox = Inbox(self._history, settings.data / IMPORTS, self._known_sites.imported)
        self._sighting_store = SightingStore(self._database)
        self.sightings = Sightings(
            self._sites, self.browsers, self._sighting_store, clock,
            settings.sightings_days, settings.sightings_most,
        )  # fmt: skip
        self._notify_store = NotifyStore(self._database, self._seal)
        self._sender = Sender(settings.notify_networks)
        self._delivering = Delivering(
            notices, self._notify_store, self._sender, clock, self.alarms.refresh_troubles
        )
        self.alarms.on_notice(self._delivering.wake)
        self._tasks: list[asyncio.Task[None]] = []
        self.app = self._application()
        self.asgi: ASGIApp = Shield(self.app, settings)

    async def start(self) -> None:
        """Open the database and bring back what was known.

        Raises:
            StoreError: the database cannot be opened.
            CannotStart: the key that seals secrets cannot be read.

        """
        self._seal()
        await self._database.migrate()
        await self._tries.bring_back()
        await self._history.open()
        await self._known_sites.remember()
        # First what became of messages: the alarms show it.
        await self._delivering.recover()
        await self.alarms.open()
        await self.sightings.open()
        for live in self._sites:
            self._detecting.described(live)
        await self._recordings.open()
        self.setup_token = await self._people.offer_setup(self.settings.setup_s)
        self._tasks = [
            asyncio.create_task(self._audit.run()),
            asyncio.create_task(self._registry.attendance.run()),
            asyncio.create_task(self.alarms.run()),
            asyncio.create_task(self.sightings.run()),
            asyncio.create_task(self._delivering.run()),
            asyncio.create_task(self._seats.watch(self.settings.check_s)),
            asyncio.create_task(self._links.watch(self.settings.check_s)),
            asyncio.create_task(self._inbox.run()),
            asyncio.create_task(self._watching.run()),
        ]
        self._audit.note("hub started")

    async def close(self) -> None:
        """Let go of everything; what was noted is written first."""
        self._media.close()
        await self._detecting.close()
        if self._tasks:
            auditing, attending, alarming, seeing, *watching = self._tasks
            for task in watching:
                task.cancel()
            self._audit.note("hub stopped")
            # What it tells alarms last is written by them.
            self.sightings.stop()
            await asyncio.gather(seeing, return_exceptions=True)
            self.alarms.stop()
            self._audit.stop()
            self._registry.attendance.stop()
            await asyncio.gather(auditing, attending, alarming, *watching, return_exceptions=True)
            await self._watching.close()
        await self._history.close()
        await self._database.close()

    def cached_bytes(self) -> int:
        """Give the memory of what was read of the history and may be asked for again (bytes)."""
        return self._history.cached_bytes

    def driven(self) -> bool:
        """Tell whether somebody has control of a device anywhere."""
        return any(state.session for live in self._sites for state, _ in live.leases.values())

    def _application(self) -> FastAPI:
        access = Access(
            self._sessions,
            self._tokens,
            self._sites,
            self._registry,
            Admission(),
            self.settings,
        )
        app = FastAPI(
            title="Talaia hub",
            # The browser's own pages speak to it; the description is made by the docs.
            openapi_url=None,
            lifespan=self._lifespan,
            redirect_slashes=False,
        )
        answer_problems(app)
        limits = Limits(self._clock)
        guarded = [Depends(access.guard), Depends(limits.ask)]
        for routes in (
            *self._account_pages(access),
            self._site_pages(),
            HistoryPages(self._history),
            AnomalyPages(self._watching, self._audit),
            ArchivePages(self._archive),
            SkyPages(),
            RecordingPages(self._recordings, self._audit),
            DescriptionPages(self._descriptions, self._changes, self._audit),
            AlarmPages(
                self.alarms,
                self._alarm_store,
                self._people,
                self._history,
                self._audit,
                self._clock,
            ),
            SightingPages(self._sighting_store),
            NotifyPages(self._notify_store, self._sender, self._audit, self._clock),
            self._gateway_pages(),
            AuditPages(self._audit),
            ApiDescription(lambda: app),
            StoragePages(self._history, self._sites, self._clock),
            Pages(static_dir()),
        ):
            app.include_router(routes.router(), dependencies=guarded)
        app.router.routes[0:0] = self._sockets(access, limits).router().routes
        return app

    def _account_pages(
        self, access: Access
    ) -> tuple[Accounts, OwnPages, TokenPages, PeoplePages, RolePages]:
        proving = Proving(
            access,
            self._people,
            self._passwords,
            self._factors,
            self._known,
            self._throttle,
            self._tries,
            self._audit,
            self._clock,
        )
        parts = AccountParts(
            access,
            proving,
            self._people,
            self._passwords,
            self._sessions,
            self._factors,
            self._known,
            self._seats,
            self._audit,
        )
        return (
            Accounts(parts),
            OwnPages(parts),
            TokenPages(self._tokens, self._seats, self._audit, self._clock),
            PeoplePages(
                self._people,
                Roster(self._database, self._sessions),
                self._passwords,
                self._sessions,
                self._factors,
                self._seats,
                self._audit,
            ),
            RolePages(Roles(self._database), self._seats, self._audit),
        )

    def _site_pages(self) -> SitePages:
        return SitePages(self._sites, self._audit, self._sighting_store, self._clock)

    def _gateway_pages(self) -> GatewayPages:
        enrolment = Enrolment(self._database, self._clock)
        return GatewayPages(
            self._registry, enrolment, self._links, self._audit, self._clock, self._proof
        )

    def _proof(self) -> Proof:
        if self.settings.plain:
            return Proof()
        cert = certificate_of(self.settings).cert
        return Proof(fingerprint(cert), key_hash(cert))

    def _sockets(self, access: Access, limits: Limits) -> Sockets:
        browsers = self.browsers
        commanding = Commanding(self._sites, self._audit)
        reporting = Reporting(self._sites, browsers, self.alarms, self._audit, self._clock)
        self._watching.listen(reporting)
        self._watching.listen(self.alarms)
        self.sightings.listen(self.alarms)
        self._watching.show(reporting)
        places = Places(
            self._sites,
            self._media,
            self.sightings,
            reporting,
            self.fanout,
            self.alarms,
            self._watching,
            self._history,
        )
        models = self.settings.data / MODELS
        self._detecting = Detecting(places, lambda told: Worker({}, models, told), self._clock)
        parts = Parts(
            sites=self._sites,
            browsers=browsers,
            fanout=self.fanout,
            reporting=reporting,
            alarms=self.alarms,
            sightings=self.sightings,
            detecting=self._detecting,
            media=self._media,
            history=self._history,
            registry=self._registry,
            versions=self._descriptions,
            changes=self._changes,
            links=self._links,
            uploads=self._uploads,
            recordings=self._recordings,
            watching=self._watching,
            settings=self.settings,
            clock=self._clock,
        )
        gateways = Gateways(parts, Describing(parts), Admission())
        return Sockets(
            access,
            limits,
            self._sites,
            Gate(self._sites, lambda: self._seats.sure),
            self._seats,
            browsers,
            self.fanout,
            commanding,
            reporting,
            self.sightings,
            self._media,
            gateways,
            self._clock,
        )

    @asynccontextmanager
    async def _lifespan(self, _app: FastAPI) -> AsyncIterator[None]:
        await self.start()
        try:
            yield
        finally:
            await self.close()


def build(settings: Settings, clock: Clock, history: History | None = None) -> Hub:
    """Put a hub together; ``history`` takes the place of the one in the settings' database.

    Raises:
        StoreError: the database's URL cannot be used.

    """
    return Hub(settings, clock, history)
