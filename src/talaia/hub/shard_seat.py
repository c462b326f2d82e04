"""A hub's seat for one shard: it waits and hands through, or it leads and answers.

Long, because all of its life stands in one place.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import sys
import time
from typing import TYPE_CHECKING, NamedTuple

from talaia import __version__
from talaia.hub.api.problems import problem_response
from talaia.hub.app import build_hub
from talaia.hub.auth.secret_box import SEAL_FILE, seal_of
from talaia.hub.cluster.entrance import NoLead
from talaia.hub.cluster.lead_wait import HeldOpening, LeadWait
from talaia.hub.cluster.local_requests import LocalRequests
from talaia.hub.cluster.member import ClusterMember
from talaia.hub.cluster.nats_bus import NatsBus
from talaia.hub.errors import HubError
from talaia.hub.sharding.elsewhere_guard import ElsewhereGuard
from talaia.hub.sharding.plan import MAIN
from talaia.hub.store.lead.hub_plan import agree_on_plan
from talaia.hub.store.lead.lead_claim import claim_lead
from talaia.hub.store.lead.lead_lock import LOOK_S, LeadLock

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterable

    from sqlalchemy.engine.interfaces import DBAPIConnection
    from starlette.responses import Response
    from starlette.types import ASGIApp, Receive, Scope, Send

    from talaia.clock import Clock
    from talaia.hub.app import Hub
    from talaia.hub.cluster.peers import HubNotice
    from talaia.hub.settings import Settings
    from talaia.hub.sharding.plan import ShardPlan
    from talaia.hub.store.database import Database

__all__ = ["NO_LEAD", "SeatRules", "ShardSeat", "answer_response"]

_LOG = logging.getLogger(__name__)
# Features of a hub that was superseded are closed no longer than this (s): the process ends.
_CLOSE_S = 2.0
# Cut off from the database and from all others for so long, a lead lets its gateways go (s).
_ALONE_S = 10.0
# A hub that is to begin anew closes within this (s), or its whole process begins anew.
_ANEW_S = 20.0
# Hubs that a socket's opening is handed to, one after the other as they go.
_TRIES = 3
# The first look at a lock is waited for no longer (s).
_FIRST_LOOK_S = 5.0
NO_LEAD = "no hub leads just now; one takes over within seconds"
_ELSEWHERE = "another hub has this site by now; ask again"
_NO_SHARD_LEAD = "no hub leads the shard {} just now; one takes over within seconds"


class SeatRules(NamedTuple):
    """What a process tells each of its seats.

    Attributes:
        may_take: whether a seat may take its shard's lead, which nobody has had for so long (s).
        superseded: another hub leads a shard that this process has led.
        failed: a seat cannot lead, and why.
        data_lock: has the data folder, for as long as a seat leads.

    """

    may_take: Callable[[ShardSeat, float], bool]
    superseded: Callable[[], None]
    failed: Callable[[HubError], None]
    data_lock: Callable[[], contextlib.AbstractContextManager[None]]


class ShardSeat:
    """The place of this hub at one shard. Call it with a request, whoever leads that shard.

    Attributes:
        settings: of this hub.
        shard: its name; ``main`` has the accounts.
        plan: which shards there are.
        member: this hub among the others, for this shard.
        taken: this hub has the lead's lock.

    """

    def __init__(
        self,
        settings: Settings,
        clock: Clock,
        *,
        shard: str,
        plan: ShardPlan,
        rules: SeatRules,
    ) -> None:
        """Build the hub that it is when it leads; nothing is opened yet.

        Raises:
            HubError: the settings do not fit, or a library is missing.

        """
        self.settings, self._clock = settings, clock
        self.shard, self.plan = shard, plan
        self._rules = rules
        # All hubs have the same key: of it comes the one by which they know each other.
        purpose = "frames between hubs" if shard == MAIN else f"frames between hubs of {shard}"
        key = seal_of(settings.data / SEAL_FILE).derive_key(purpose)
        bus = NatsBus(settings.cluster, name=settings.hub_name, ca=settings.cluster_ca)
        self.member = ClusterMember(
            bus,
            clock,
            key=key,
            name=settings.hub_name,
            version=__version__,
            superseded=self._supersede,
        )
        self._lock = LeadLock(
            settings.url,
            taken=self._take_lead,
            lost=self._lose_lead,
            shard=shard,
            shards=plan.names,
            may_take=self._may_take if plan.names else None,
        )
        self.member.database_ms = lambda: self._lock.answered_ms
        self._waiting = LeadWait(self._has_lead, self._expects_lead)
        self.member.lead_heard = self._waiting.notify
        # Built while nobody waits for it; it opens when this hub leads.
        self._hub: Hub = build_hub(settings, clock, seat=self)
        self._leading: Hub | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self.taken = asyncio.Event()
        self._leaving = False
        self._over = False
        self._closing = asyncio.Event()
        # Its hub is to close and to open again: sites have gone to other shards, or come.
        self._anew = asyncio.Event()
        self._local = LocalRequests()
        self._closed = asyncio.Event()
        self._failed = False
        self._epoch = 0
        # Since when no hub has led this shard, as far as is heard (monotonic, s).
        self._vacant_s = time.monotonic()

    @property
    def leading(self) -> Hub | None:
        """The hub, while it is this one that leads."""
        return self._leading

    @property
    def holds_lead(self) -> bool:
        """Whether this hub leads, or is about to."""
        return self.taken.is_set()

    @property
    def led_lately(self) -> bool:
        """Whether some hub leads this shard, or did a moment ago."""
        return self._leading is not None or self._anew.is_set() or self.member.led_lately

    # ── its seat among the others ──

    @property
    def connected(self) -> bool:
        """Whether the hubs can hear each other."""
        return self.member.connected

    def check_connection(self, connection: DBAPIConnection, record: object) -> None:
        """Refuse a new connection to the database unless this hub leads."""
        self._lock.check_connection(connection, record)

    async def claim_lead(self, database: Database, seal_hash: str) -> None:
        """Write down that this hub leads now."""
        await agree_on_plan(database, self.plan.names, shard=self.shard)
        self._epoch = await claim_lead(
            database, shard=self.shard, name=self.settings.hub_name, seal_hash=seal_hash
        )
        self._lock.remember_epoch(self._epoch)

    def begin_anew(self) -> None:
        """Close the hub that leads, and open another one in its place; soon."""
        self._anew.set()

    def own_notice(self) -> HubNotice:
        """Say how this hub stands."""
        return self.member.own_notice()

    def heard_hubs(self) -> Iterable[tuple[HubNotice, int]]:
        """Give how the others stand, and when each was heard last."""
        return list(self.member.peers)

    # ── serving ──

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer here, or hand through to the hub that leads this shard.

        Where none does, it is said so: HTTP 503 with the code ``busy``.
        """
        opening = HeldOpening(receive)
        for _ in range(_TRIES):
            if not await self._waiting.wait_for_lead(opening.began_s):
                break
            hub = self._leading
            if hub is not None and not self.plan.names:
                await hub.asgi(scope, opening.receive, send)
                return
            if hub is not None:
                app = self._guarded(hub)
                if await self._local.serve(app, scope, opening.receive, send):
                    return
                # As below.
                if scope["type"] != "websocket" or not opening.begin_again():
                    break
                continue
            try:
                await self.member.entrance.serve_request(scope, opening.receive, send)
            except NoLead as error:
                _LOG.debug("%s %s: %s", scope["type"], scope["path"], error)
                # Of a request nobody knows whether the hub that is gone has done it; a socket that
                # was not opened has done nothing.
                if scope["type"] != "websocket" or not opening.begin_again():
                    break
            else:
                return
        opening.begin_again()
        await self.refuse_request(scope, opening.receive, send)

    async def refuse_request(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Say that no hub leads this shard just now."""
        said = NO_LEAD if self.shard == MAIN else _NO_SHARD_LEAD.format(self.shard)
        await answer_response(problem_response(503, "busy", said, 1), scope, receive, send)

    def _has_lead(self) -> bool:
        return self._leading is not None or self.member.find_lead() is not None

    def _expects_lead(self) -> bool:
        """Tell whether a hub may lead soon, and be heard here."""
        if self._leaving or self._over or not self.member.connected:
            return False
        # Lists of all sites ask every shard: for one that nobody leads they must not wait each
        # time. Without the main one there is nothing that could be answered instead.
        return self.shard == MAIN or self.taken.is_set() or self.member.led_lately

    # ── its life ──

    async def hand_over(self) -> None:
        """Send those who are in to other hubs; nobody new comes from now on."""
        self._leaving = True
        if self._over:
            return
        if self._lock.held:
            # All links change when the lead does. They are told at once, wherever they came in, so
            # that none goes to another hub and from there back to this one.
            await self.member.leave_others()
        else:
            # It would lead for a moment, and everybody would have to come a second time.
            await asyncio.to_thread(self._lock.stop_looking)
            await self.member.hand_over()

    @contextlib.asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """Be there, for as long as the block lasts."""
        self._loop = asyncio.get_running_loop()
        self._vacant_s = time.monotonic()
        await self.member.open()
        self._lock.start_looking()
        # Of several seats of a process one looks after the other: each sees what those before it
        # have got.
        if self.plan.names:
            await asyncio.to_thread(self._lock.tried.wait, _FIRST_LOOK_S)
        tasks = [
            asyncio.create_task(self._lead(), name="lead"),
            asyncio.create_task(self.member.run(), name="say that this hub is there"),
            asyncio.create_task(self._watch_isolation(), name="watch whether it is cut off"),
        ]
        if self.plan.names:
            tasks.append(asyncio.create_task(self._watch_vacancy(), name="watch for a lead"))
        try:
            yield
        finally:
            self._leaving = True
            self._closing.set()
            await self.member.leave_others()
            # What it leads is written and closed before another one may begin.
            closing = _CLOSE_S if self._over and not self._failed else None
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(closing):
                    if self._leading is not None or self._anew.is_set():
                        await self._closed.wait()
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            await asyncio.to_thread(self._lock.stop_looking)
            await self.member.close()

    async def _lead(self) -> None:
        """Wait for the lock, then be the hub until the end."""
        await self.taken.wait()
        _LOG.info("this hub has the lock of the shard %s; it opens", self.shard)
        await self.member.begin_opening()
        try:
            with self._rules.data_lock():
                while not self._closing.is_set():
                    await self._lead_once()
        except HubError as error:
            self._over = self._failed = True
            self._rules.failed(error)
        finally:
            self._closed.set()

    async def _lead_once(self) -> None:
        """Be the hub until the end, or until it is to begin anew."""
        async with self._hub.running():
            self._anew.clear()
            self._leading = self._hub
            self._waiting.notify()
            await self.member.begin_leading(self._guarded(self._hub), self._epoch)
            self._announce()
            ends = [asyncio.create_task(event.wait()) for event in (self._closing, self._anew)]
            await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
            for end in ends:
                end.cancel()
            if self._closing.is_set():
                return
            _LOG.warning("the sites of the shard %s have changed; its hub begins anew", self.shard)
            # In a thread, for it takes a while, and another shard of this process goes on.
            building = asyncio.create_task(
                asyncio.to_thread(build_hub, self.settings, self._clock, seat=self)
            )
            # One that does not close is left behind with its process.
            late = asyncio.get_running_loop().call_later(_ANEW_S, self._supersede)
            self._leading = None
            await self.member.pause_leading()
            await self._local.end_all()
        late.cancel()
        self._hub = await building

    def _guarded(self, hub: Hub) -> ASGIApp:
        if not self.plan.names:
            return hub.asgi
        return ElsewhereGuard(hub.asgi, hub.core.shard, _refuse_elsewhere)

    async def _watch_isolation(self) -> None:
        """End a lead that neither the database nor any other hub hears."""
        alone_s = 0.0
        while True:
            await asyncio.sleep(1.0)
            others = any(True for _ in self.member.peers)
            cut_off = not self._lock.held and not self.member.connected
            alone_s = alone_s + 1.0 if self._leading and others and cut_off else 0.0
            if alone_s >= _ALONE_S:
                _LOG.error("neither the database nor another hub is reached; gateways may go")
                self._supersede()

    async def _watch_vacancy(self) -> None:
        """Know since when nobody leads: a hub that leads another shard takes this one later."""
        while True:
            if self.taken.is_set() or self.member.hears_lead:
                self._vacant_s = time.monotonic()
            await asyncio.sleep(LOOK_S)

    def _announce(self) -> None:
        _LOG.warning("this hub leads the shard %s, as number %d", self.shard, self._epoch)
        of_shard = "" if self.shard == MAIN else f" (shard {self.shard})"
        lines = [f"talaia hub leads: {self.settings.hub_name}{of_shard}"]
        if self._hub.setup_token:
            lines.append(f"set up the first admin within a day: /setup#{self._hub.setup_token}")
        sys.stdout.write("\n".join(lines) + "\n")
        sys.stdout.flush()

    def _may_take(self) -> bool:
        # In the lock's thread.
        return self._rules.may_take(self, time.monotonic() - self._vacant_s)

    def _take_lead(self) -> None:
        self._call_in_loop(self.taken.set)

    def _lose_lead(self) -> None:
        self._call_in_loop(self._supersede)

    def _supersede(self) -> None:
        """Another one leads: whatever this process has in memory is of the past."""
        if not self._over:
            self._over = True
            _LOG.error("this hub does not lead the shard %s any more; it begins anew", self.shard)
            self._rules.superseded()

    def _call_in_loop(self, act: Callable[[], None]) -> None:
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(act)


async def _refuse_elsewhere(scope: Scope, receive: Receive, send: Send) -> None:
    await answer_response(problem_response(503, "elsewhere", _ELSEWHERE, 1), scope, receive, send)


async def answer_response(response: Response, scope: Scope, receive: Receive, send: Send) -> None:
    """Give an answer to a request, or to who wants to open a socket: as its denial."""
    if scope["type"] != "websocket":
        await response(scope, receive, send)
        return
    # ASGI: first the other side's wish to connect is taken.
    await receive()
    start = {"status": response.status_code, "headers": response.raw_headers}
    await send({"type": "websocket.http.response.start", **start})
    await send({"type": "websocket.http.response.body", "body": bytes(response.body)})
