"""What a feature of the hub is: a part that builds itself and says what it brings."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from sqlalchemy.exc import OperationalError

from talaia.hub.auth.resume_tokens import ResumeTokens
from talaia.hub.auth.secret_box import SEAL_FILE, seal_of
from talaia.hub.live.pages.fanout import Fanout
from talaia.hub.live.pages.page_connections import Browsers
from talaia.hub.live.site_mirror import SiteMirror
from talaia.hub.live.sites import Sites
from talaia.hub.live.taps.tap_fanout import TapFanout
from talaia.hub.policy import ROUTES_OF
from talaia.hub.sharding.own_shard import OwnShard
from talaia.hub.sharding.plan import WholeShard
from talaia.hub.store.database import Database
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.history_servers.shard_handover import ShardHandover
from talaia.hub.store.lead.hub_plan import agree_on_plan

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Mapping, Sequence

    from fastapi import APIRouter
    from sqlalchemy.engine.interfaces import DBAPIConnection

    from talaia.clock import Clock
    from talaia.hub.auth.secret_box import Seal
    from talaia.hub.policy import AccessNeed
    from talaia.hub.ports import ClusterSeat, DescribedSites, Shard
    from talaia.hub.settings import Settings

__all__ = ["BackgroundTask", "Core", "Feature"]


class Core:
    """What every feature may use: nothing that belongs to one of them.

    Attributes:
        settings: of this hub.
        clock: the time.
        seat: this hub's place among several; none: it is alone.
        shard: which sites are this hub's own.
        on_connect: looks at each new connection to the database; none: nobody need.
        database: for all that is kept, but the history.
        sites: this hub's own sites as they are now.
        known_sites: what is described, also of sites of other shards where this is the main one.
        browsers: the pages that are connected now.
        fanout: who of them gets which live values.
        taps: who gets which raw topics of robots.
        resumes: by what gateways are known that were linked before.
        followers: what of these goes by the sites' descriptions.

    """

    def __init__(
        self, *, settings: Settings, clock: Clock, seat: ClusterSeat | None = None
    ) -> None:
        """Build it; nothing is opened yet. ``seat``: of this hub, where several are one.

        Raises:
            StoreError: the database's URL cannot be used.

        """
        self.settings = settings
        self.clock = clock
        # Checks the URL and connects to nothing yet.
        self.seat = seat
        self.on_connect = None if seat is None else self._check_connection
        self._closed = False
        divided = seat is not None and bool(seat.plan.names)
        self.database = Database(settings.url, on_connect=self.on_connect, shares_turn=divided)
        self.shard: Shard = WholeShard()
        if seat is not None and divided:
            self.shard = OwnShard(
                seat.shard,
                seat.plan,
                HistoryHomes(self.database),
                ShardHandover(self.database),
            )
        self.sites = Sites()
        self.known_sites: DescribedSites = self.sites
        if self.shard.is_main and not self.shard.is_whole:
            self.known_sites = SiteMirror(self.sites, self.shard, self.database)
        self.browsers = Browsers()
        self.fanout = Fanout(self.sites, clock, settings.linger_s)
        self.taps = TapFanout(self.sites, clock)
        self.followers = (self.fanout, self.taps)
        # Read once: a file that is replaced meanwhile must not change what this hub seals by.
        self._seal = functools.cache(lambda: seal_of(settings.data / SEAL_FILE))
        # A key of its own, from the same file: it is backed up with it, and is in no database.
        self.resumes = ResumeTokens(
            functools.cache(lambda: self.secret_box().derive_key("places of gateways")), clock
        )

    def secret_box(self) -> Seal:
        """Give what seals secrets; its key is read from the data folder the first time.

        Raises:
            CannotStart: the key cannot be read.

        """
        return self._seal()

    async def open(self) -> None:
        """Read the key and open the database.

        Raises:
            CannotStart: the key that seals secrets cannot be read.
            StoreError: the database cannot be opened.

        """
        # Before the database: a key that cannot be read is told before anything is migrated.
        self.secret_box()
        await self.database.migrate()
        if self.seat is None:
            # It has all sites: hubs that divided them lead none any more.
            await agree_on_plan(self.database, ())
        if self.seat is not None:
            purpose = "which hubs belong together"
            await self.seat.claim_lead(self.database, self.secret_box().derive_key(purpose).hex())
        await self.shard.open()

    async def close(self) -> None:
        """Close the database."""
        # Another hub of this process may lead after this one: whatever is left of this writes
        # nothing any more.
        self._closed = True
        self.fanout.watched.close()
        await self.database.close()

    def _check_connection(self, connection: DBAPIConnection, record: object) -> None:
        if self._closed:
            raise OperationalError("connect", None, ConnectionError("this hub is closed"))
        if self.seat is not None:
            self.seat.check_connection(connection, record)


@dataclass(frozen=True, kw_only=True)
class BackgroundTask:
    """What a feature does while the hub is open.

    Attributes:
        name: within its feature, for the log and for who looks at the event loop.
        run: does it until cancelled, or until ``stop`` was called.
        stop: lets ``run`` write down what waits and end; none: it is cancelled.

    """

    name: str
    run: Callable[[], Coroutine[Any, Any, None]]
    stop: Callable[[], None] | None = None


class Feature:
    """One feature: its routes, its lines of the policy table, its background tasks.

    Subclasses build their parts in ``__init__``, and name as attributes what they offer to others.

    Attributes:
        name: of the feature, as in the policy table.
        routers: its HTTP routes, which are guarded by the policy table.
        sockets: its WebSocket routes, which admit by themselves.
        tasks: what runs while the hub is open.

    """

    # Class attributes, so that a feature without any of these need not say so.
    name: ClassVar[str]
    routers: Sequence[APIRouter] = ()
    sockets: Sequence[APIRouter] = ()
    tasks: Sequence[BackgroundTask] = ()

    @property
    def rules(self) -> Mapping[tuple[str, str], AccessNeed]:
        """The lines of the policy table for its routes."""
        return ROUTES_OF.get(self.name, {})

    async def open(self) -> None:
        """Bring back what was known; every feature before it is open, and no task runs yet."""

    async def close(self) -> None:
        """Let go of everything; its tasks have ended, and every feature before it is open."""
