"""A hub among several on one database: it waits and hands through, or it leads and answers.

Long, because its life and what it answers meanwhile stand in one place.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import sys
from typing import TYPE_CHECKING

from starlette.requests import Request
from starlette.responses import JSONResponse

from talaia import __version__
from talaia.hub.api.problems import problem_response
from talaia.hub.api.server.request_guard import RequestGuard
from talaia.hub.api.static_pages import Pages
from talaia.hub.app import build_hub
from talaia.hub.auth.secret_box import SEAL_FILE, seal_of
from talaia.hub.cluster.entrance import NoLead
from talaia.hub.cluster.lead_wait import HeldOpening, LeadWait
from talaia.hub.cluster.member import ClusterMember
from talaia.hub.cluster.nats_bus import NatsBus
from talaia.hub.errors import HubError
from talaia.hub.lock import HubRuns, hub_lock
from talaia.hub.store.lead.lead_claim import claim_lead
from talaia.hub.store.lead.lead_lock import LeadLock
from talaia.web import static_dir

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterable, Iterator

    from sqlalchemy.engine.interfaces import DBAPIConnection
    from starlette.responses import Response
    from starlette.types import Receive, Scope, Send

    from talaia.clock import Clock
    from talaia.hub.app import Hub
    from talaia.hub.cluster.peers import HubNotice
    from talaia.hub.settings import Settings
    from talaia.hub.store.database import Database

__all__ = ["ClusterHub"]

_LOG = logging.getLogger(__name__)
# Features of a hub that was superseded are closed no longer than this (s): the process ends.
_CLOSE_S = 2.0
# Cut off from the database and from all others for so long, a lead lets its gateways go (s).
_ALONE_S = 10.0
# Hubs that a socket's opening is handed to, one after the other as they go.
_TRIES = 3
_NO_LEAD = "no hub leads just now; one takes over within seconds"


class ClusterHub:
    """One of several hubs. Serve `asgi`; all of it starts and ends with the server's lifespan.

    Attributes:
        settings: of this hub.
        ended: set when this hub cannot go on: `failure` says why, or another one leads now.
        failure: what kept it from leading; none.

    """

    def __init__(self, settings: Settings, clock: Clock) -> None:
        """Build the hub that it is when it leads; nothing is opened yet.

        Raises:
            HubError: the settings do not fit, or a library is missing.

        """
        self.settings = settings
        self._clock = clock
        # All hubs have the same key: of it comes the one by which they know each other.
        key = seal_of(settings.data / SEAL_FILE).derive_key("frames between hubs")
        bus = NatsBus(settings.cluster, name=settings.hub_name, ca=settings.cluster_ca)
        self._member = ClusterMember(
            bus,
            clock,
            key=key,
            name=settings.hub_name,
            version=__version__,
            superseded=self._supersede,
        )
        self._lock = LeadLock(settings.url, taken=self._take_lead, lost=self._lose_lead)
        self._member.database_ms = lambda: self._lock.answered_ms
        self._member.count_own = self._count_own
        self._waiting = LeadWait(self._has_lead, self._expects_lead)
        self._member.lead_heard = self._waiting.notify
        # Built while nobody waits for it; it opens when this hub leads.
        self._hub: Hub = build_hub(settings, clock, seat=self)
        self._leading: Hub | None = None
        # What this hub answers without being the lead, guarded like everything else.
        self._own = RequestGuard(self._answer_own, settings)
        self._pages = Pages(static_dir())
        self._loop: asyncio.AbstractEventLoop | None = None
        self._taken = asyncio.Event()
        self._leaving = False
        self._closing = asyncio.Event()
        self._closed = asyncio.Event()
        self.ended = asyncio.Event()
        self.failure: HubError | None = None
        self._epoch = 0
        # Sockets that came here while this hub leads, by path.
        self._gateways = self._sockets = 0

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
        return self._leading is None or self._leading.judging

    def is_driven(self) -> bool:
        """Tell whether somebody has control of a device through this hub."""
        return self._leading is not None and self._leading.is_driven()

    def cached_bytes(self) -> int:
        """Give the memory of what may be asked for again (bytes)."""
        return 0 if self._leading is None else self._leading.cached_bytes()

    async def hand_over(self) -> None:
        """Send those who are in to other hubs; nobody new comes from now on."""
        self._leaving = True
        if self.ended.is_set():
            return
        if self._lock.held:
            # All links change when the lead does. They are told at once, wherever they came in, so
            # that none goes to another hub and from there back to this one.
            await self._member.leave_others()
        else:
            # It would lead for a moment, and everybody would have to come a second time.
            await asyncio.to_thread(self._lock.stop_looking)
            await self._member.hand_over()

    # ── its seat among the others ──

    @property
    def connected(self) -> bool:
        """Whether the hubs can hear each other."""
        return self._member.connected

    def check_connection(self, connection: DBAPIConnection, record: object) -> None:
        """Refuse a new connection to the database unless this hub leads."""
        self._lock.check_connection(connection, record)

    async def claim_lead(self, database: Database, seal_hash: str) -> None:
        """Write down that this hub leads now."""
        name = self.settings.hub_name
        self._epoch = await claim_lead(database, name=name, seal_hash=seal_hash)
        self._lock.remember_epoch(self._epoch)

    def own_notice(self) -> HubNotice:
        """Say how this hub stands."""
        return self._member.own_notice()

    def heard_hubs(self) -> Iterable[tuple[HubNotice, int]]:
        """Give how the others stand, and when each was heard last."""
        return list(self._member.peers)

    # ── serving ──

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer here, or hand through to the hub that leads."""
        if scope["type"] == "lifespan":
            await self._live(receive, send)
            return
        if scope["path"] in {"/api/health", "/api/ready"}:
            await self._own(scope, receive, send)
            return
        if self._leading is None and self._is_asset(scope):
            await self._own(scope, receive, send)
            return
        opening = HeldOpening(receive)
        for _ in range(_TRIES):
            if not await self._waiting.wait_for_lead(opening.began_s):
                break
            hub = self._leading
            if hub is not None:
                with self._counted(scope):
                    await hub.asgi(scope, opening.receive, send)
                return
            try:
                await self._member.entrance.serve_request(scope, opening.receive, send)
            except NoLead as error:
                _LOG.debug("%s %s: %s", scope["type"], scope["path"], error)
                # Of a request nobody knows whether the hub that is gone has done it; a socket that
                # was not opened has done nothing.
                if scope["type"] != "websocket" or not opening.begin_again():
                    break
            else:
                return
        opening.begin_again()
        await self._own(scope, opening.receive, send)

    async def _answer_own(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer what needs no lead: whether it is well, assets, and that none leads."""
        path = scope["path"]
        if path == "/api/health":
            answer: Response = JSONResponse({"ok": True})
        elif path == "/api/ready" and self._is_ready():
            answer = JSONResponse({"ok": True})
        elif path == "/api/ready" or scope["type"] == "websocket" or not self._is_asset(scope):
            answer = problem_response(503, "busy", _NO_LEAD, 1)
        else:
            answer = self._pages.page(Request(scope, receive), path.removeprefix("/"))
        if scope["type"] == "websocket":
            # ASGI: first the other side's wish to connect is taken.
            await receive()
            start = {"status": 503, "headers": answer.raw_headers}
            await send({"type": "websocket.http.response.start", **start})
            await send({"type": "websocket.http.response.body", "body": bytes(answer.body)})
        else:
            await answer(scope, receive, send)

    def _is_ready(self) -> bool:
        if self._leaving or self.ended.is_set():
            return False
        # Who comes within a take-over is held until it is done: were no hub ready, a load balancer
        # would send everybody away, and they would come again at one blow.
        return self._leading is not None or self._member.led_lately

    def _has_lead(self) -> bool:
        return self._leading is not None or self._member.find_lead() is not None

    def _expects_lead(self) -> bool:
        """Tell whether a hub may lead soon, and be heard here."""
        return self._member.connected and not (self._leaving or self.ended.is_set())

    def _is_asset(self, scope: Scope) -> bool:
        # Named by their content: the same at every hub that has it, and open to all.
        return (
            scope["type"] == "http"
            and scope["method"] in {"GET", "HEAD"}
            and scope["path"].startswith("/assets/")
            and (static_dir() / scope["path"].removeprefix("/")).is_file()
        )

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

    def _count_own(self) -> tuple[int, int]:
        return self._gateways, self._sockets

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
        self._loop = asyncio.get_running_loop()
        await self._member.open()
        self._lock.start_looking()
        tasks = [
            asyncio.create_task(self._lead(), name="lead"),
            asyncio.create_task(self._member.run(), name="say that this hub is there"),
            asyncio.create_task(self._watch_isolation(), name="watch whether it is cut off"),
        ]
        try:
            yield
        finally:
            self._leaving = True
            self._closing.set()
            await self._member.leave_others()
            # What it leads is written and closed before another one may begin.
            closing = _CLOSE_S if self._superseded else None
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(closing):
                    if self._leading is not None:
                        await self._closed.wait()
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            await asyncio.to_thread(self._lock.stop_looking)
            await self._member.close()

    async def _lead(self) -> None:
        """Wait for the lock, then be the hub until the end."""
        await self._taken.wait()
        _LOG.info("this hub has the lock; it opens")
        await self._member.begin_opening()
        try:
            with self._data_lock():
                async with self._hub.running():
                    self._leading = self._hub
                    self._waiting.notify()
                    await self._member.begin_leading(self._hub.asgi, self._epoch)
                    self._announce()
                    await self._closing.wait()
        except HubError as error:
            self.failure = error
            self.ended.set()
        finally:
            self._closed.set()

    @contextlib.contextmanager
    def _data_lock(self) -> Iterator[None]:
        """Have the data folder, so that an import sees that a hub runs."""
        try:
            with hub_lock(self.settings.data):
                yield
        except HubRuns:
            # Hubs may share a folder, and one that stands still has it yet: the database's own
            # lock is what counts.
            _LOG.warning(
                "the data folder is locked by another program; this hub leads all the same"
            )
            yield

    async def _watch_isolation(self) -> None:
        """End a lead that neither the database nor any other hub hears."""
        alone_s = 0.0
        while True:
            await asyncio.sleep(1.0)
            others = any(True for _ in self._member.peers)
            cut_off = not self._lock.held and not self._member.connected
            alone_s = alone_s + 1.0 if self._leading and others and cut_off else 0.0
            if alone_s >= _ALONE_S:
                _LOG.error("neither the database nor another hub is reached; gateways may go")
                self._supersede()

    def _announce(self) -> None:
        _LOG.warning("this hub leads, as number %d", self._epoch)
        lines = [f"talaia hub leads: {self.settings.hub_name}"]
        if self._hub.setup_token:
            lines.append(f"set up the first admin within a day: /setup#{self._hub.setup_token}")
        sys.stdout.write("\n".join(lines) + "\n")
        sys.stdout.flush()

    @property
    def _superseded(self) -> bool:
        return self.ended.is_set() and self.failure is None

    def _take_lead(self) -> None:
        self._call_in_loop(self._taken.set)

    def _lose_lead(self) -> None:
        self._call_in_loop(self._supersede)

    def _supersede(self) -> None:
        """Another one leads: whatever this process has in memory is of the past."""
        if not self.ended.is_set():
            _LOG.error("this hub does not lead any more; it begins anew")
            self.ended.set()

    def _call_in_loop(self, act: Callable[[], None]) -> None:
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(act)
