"""A hub among several on one database: it has a seat at each shard, and leads whoever comes there.

Where sites are not divided there is one shard, and one seat.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from typing import TYPE_CHECKING

from starlette.requests import Request
from starlette.responses import JSONResponse

from talaia.hub.api.problems import problem_response
from talaia.hub.api.server.request_guard import RequestGuard
from talaia.hub.api.static_pages import Pages
from talaia.hub.history.servers.server_file import read_history_servers
from talaia.hub.lock import HubRuns, hub_lock
from talaia.hub.shard_seat import NO_LEAD, SeatRules, ShardSeat, answer_response
from talaia.hub.sharding.plan import MAIN, ShardPlan
from talaia.hub.store.database import Database
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.lead.lead_lock import mark_apart
from talaia.hub.store.sites.site_registry import SiteRegistry
from talaia.web import static_dir

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

    from starlette.types import ASGIApp, Receive, Scope, Send

    from talaia.clock import Clock
    from talaia.hub.errors import HubError
    from talaia.hub.settings import Settings
    from talaia.hub.sharding.directory import ShardDirectory

__all__ = ["ClusterHub"]

_LOG = logging.getLogger(__name__)
# A hub that leads a shard takes another one when nobody has led that for so long, times how many it
# leads already (s); just after its start it waits longer, for the others are about to come.
_VACANT_S, _EARLY_S = 3.0, 20.0
_ENDS = "this hub ends; come again, to another one"


class ClusterHub:
    """One of several hubs. Serve `asgi`; all of it starts and ends with the server's lifespan.

    Attributes:
        settings: of this hub.
        seats: its place at each shard, by name; the main one is the first.
        ended: set when this hub cannot go on: `failure` says why, or another one leads now.
        failure: what kept it from leading; none.

    """

    def __init__(self, settings: Settings, clock: Clock) -> None:
        """Build the hubs that it is when it leads; nothing is opened yet.

        Raises:
            HubError: the settings do not fit, or a library is missing.

        """
        self.settings = settings
        self.ended = asyncio.Event()
        self.failure: HubError | None = None
        self._clock = clock
        self._began_ns = clock.monotonic_ns()
        self._leaving = False
        # Links of gateways and other sockets that came here, whoever answers them.
        self._gateways = self._sockets = 0
        # How many of its seats have the data folder.
        self._folder_users = 0
        self._folder = contextlib.ExitStack()
        named = settings.history_servers and read_history_servers(settings.history_servers)
        plan = named.plan if named else ShardPlan()
        rules = SeatRules(
            may_take=self._may_take,
            superseded=self.ended.set,
            failed=self._fail,
            data_lock=self._data_lock,
        )
        self.seats = {
            shard: ShardSeat(settings, clock, shard=shard, plan=plan, rules=rules)
            for shard in plan.all_names
        }
        self._main = self.seats[MAIN]
        self._main.member.describe_process = self._describe_process
        # Of sites that are not divided nothing is looked at: all is the one seat's.
        self._led_on: ASGIApp = self._main
        self._looked_up: Database | None = None
        self._followed: ShardDirectory | None = None
        if named and plan.names:
            # Only here: hubs of which one leads all sites import nothing of it.
            from talaia.hub.sharding.directory import ShardDirectory
            from talaia.hub.sharding.router import ShardRouter

            apart = mark_apart(settings.url)
            self._looked_up = Database(settings.url, on_connect=apart, shares_turn=True)
            homes = HistoryHomes(self._looked_up)
            registry = SiteRegistry(self._looked_up, clock)
            directory = ShardDirectory(
                self._looked_up, homes, plan, named.first_home, registry=registry
            )
            self._led_on = ShardRouter(self.seats, directory)
            self._followed = directory
        # What this hub answers without being the lead, guarded like everything else.
        self._own = RequestGuard(self._answer_own, settings)
        self._pages = Pages(static_dir())

    # ── what a process asks of any hub ──

    @property
    def asgi(self) -> ClusterHub:
        """What a server serves."""
        return self

    @property
    def setup_token(self) -> str | None:
        """Say nothing: it is not known before this hub leads."""
        return None

    @property
    def judging(self) -> bool:
        """Whether alarms are being judged, where that is this hub's to do."""
        return all(seat.leading is None or seat.leading.judging for seat in self.seats.values())

    def is_driven(self) -> bool:
        """Tell whether somebody has control of a device through this hub."""
        return any(seat.leading and seat.leading.is_driven() for seat in self.seats.values())

    def cached_bytes(self) -> int:
        """Give the memory of what may be asked for again (bytes)."""
        return sum(seat.leading.cached_bytes() for seat in self.seats.values() if seat.leading)

    async def hand_over(self) -> None:
        """Send those who are in to other hubs; nobody new comes from now on."""
        self._leaving = True
        await asyncio.gather(*(seat.hand_over() for seat in self.seats.values()))

    # ── serving ──

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer here, or hand through to the hub that leads."""
        if scope["type"] == "lifespan":
            await self._live(receive, send)
        elif scope["path"] in {"/api/health", "/api/ready"} or self._gives_asset(scope):
            await self._own(scope, receive, send)
        else:
            with self._counted(scope):
                await self._led_on(scope, receive, send)

    async def _answer_own(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer what needs no lead: whether it is well, and assets."""
        path = scope["path"]
        if path == "/api/health" or (path == "/api/ready" and self._is_ready()):
            await answer_response(JSONResponse({"ok": True}), scope, receive, send)
        elif path == "/api/ready" or scope["type"] == "websocket":
            said = _ENDS if self._leaving else NO_LEAD
            await answer_response(problem_response(503, "busy", said, 1), scope, receive, send)
        else:
            page = self._pages.page(Request(scope, receive), path.removeprefix("/"))
            await page(scope, receive, send)

    def _is_ready(self) -> bool:
        if self._leaving or self.ended.is_set():
            return False
        # Who comes within a take-over is held until it is done: were no hub ready, a load balancer
        # would send everybody away, and they would come again at one blow.
        return self._main.led_lately

    def _gives_asset(self, scope: Scope) -> bool:
        # Named by their content: the same at every hub that has it, and open to all.
        return (
            self._main.leading is None
            and scope["type"] == "http"
            and scope["method"] in {"GET", "HEAD"}
            and scope["path"].startswith("/assets/")
            and (static_dir() / scope["path"].removeprefix("/")).is_file()
        )

    def _describe_process(self) -> tuple[int, int, tuple[str, ...]]:
        """Count all gateways and other sockets that came here; name the shards led here."""
        # Of sites that are not divided there is nothing to name.
        seats = self.seats.items() if len(self.seats) > 1 else ()
        led = tuple(name for name, seat in seats if seat.leading is not None)
        return self._gateways, self._sockets, led

    @contextlib.contextmanager
    def _counted(self, scope: Scope) -> Iterator[None]:
        gateway = scope["path"] == "/gateway/link"
        socket = scope["type"] == "websocket" and not gateway
        self._gateways += gateway
        self._sockets += socket
        try:
            yield
        finally:
            self._gateways -= gateway
            self._sockets -= socket

    # ── its life ──

    async def _live(self, receive: Receive, send: Send) -> None:
        """Start and end with the server, as ASGI has it."""
        await receive()
        async with self._running():
            await send({"type": "lifespan.startup.complete"})
            await receive()
        await send({"type": "lifespan.shutdown.complete"})

    @contextlib.asynccontextmanager
    async def _running(self) -> AsyncIterator[None]:
        async with contextlib.AsyncExitStack() as stack:
            if self._looked_up is not None:
                stack.push_async_callback(self._looked_up.close)
            for seat in self.seats.values():
                await stack.enter_async_context(seat.running())
            if self._followed is not None:
                following = asyncio.create_task(self._followed.run(), name="follow the shards")
                stack.callback(following.cancel)
            yield

    def _may_take(self, seat: ShardSeat, vacant_s: float) -> bool:
        """Tell whether a seat may take a lead: so that shards are spread over the hubs."""
        others = sum(other.holds_lead for other in self.seats.values() if other is not seat)
        if not others:
            return True
        early = self._clock.monotonic_ns() - self._began_ns < _EARLY_S * 1e9
        return not early and vacant_s >= _VACANT_S * others

    def _fail(self, error: HubError) -> None:
        self.failure = self.failure or error
        self.ended.set()

    @contextlib.contextmanager
    def _data_lock(self) -> Iterator[None]:
        """Have the data folder, so that an import sees that a hub runs; seats have it together."""
        if not self._folder_users:
            try:
                self._folder.enter_context(hub_lock(self.settings.data))
            except HubRuns:
                # Hubs may share a folder, and one that stands still has it yet: the database's own
                # lock is what counts.
                _LOG.warning(
                    "the data folder is locked by another program; this hub leads all the same"
                )
        self._folder_users += 1
        try:
            yield
        finally:
            self._folder_users -= 1
            if not self._folder_users:
                self._folder.close()
