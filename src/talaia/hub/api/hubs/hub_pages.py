"""Which hubs there are, and how each is: for admins."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter

from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.hubs.hub_problems import find_problems
from talaia.hub.api.hubs.hub_schemas import HubList, HubShape, ShardShape
from talaia.hub.cluster.peers import SILENT_S, HubNotice
from talaia.hub.sharding.plan import MAIN

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.clock import Clock
    from talaia.hub.files.ports import FileStore
    from talaia.hub.live.sites import Sites
    from talaia.hub.ports import ClusterSeat
    from talaia.hub.store.history_servers.history_homes import HistoryHomes

__all__ = ["HubPages"]


class HubPages:
    """The route of hubs."""

    def __init__(
        self,
        seat: ClusterSeat | None,
        clock: Clock,
        *,
        files: FileStore,
        sites: Sites,
        homes: HistoryHomes,
    ) -> None:
        """Answer by what ``seat`` hears of the others; none: this hub is alone.

        ``files`` are where whole files are; ``sites`` has those of this hub's own shard, ``homes``
        says which of the others have a shard of their own.
        """
        self._files = files
        self._sites = sites
        self._homes = homes
        self._seat = seat
        self._clock = clock

    def make_router(self) -> APIRouter:
        """Give the route."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/hubs")(self.hubs)
        return router

    async def hubs(self) -> HubList:
        """List the hubs that are one, how each stands, and what is wrong with them."""
        seat = self._seat
        lost = [_sentence(self._files.trouble)] if self._files.trouble else []
        if seat is None:
            return HubList(clustered=False, bus=False, epoch=0, hubs=[], shards=[], problems=lost)
        own, now_ns = seat.own_notice(), self._clock.monotonic_ns()
        heard = list(seat.heard_hubs())
        # One that was killed has said that it leads, and is not missed before it has been silent.
        newest = max(notice.epoch for notice in (own, *(notice for notice, _ in heard)))
        hubs = [_shape(own, newest, own=True, silent_s=0.0)]
        for notice, heard_ns in heard:
            silent_s = max(0.0, (now_ns - heard_ns) / 1e9)
            hubs.append(_shape(notice, newest, own=False, silent_s=round(silent_s, 1)))
        hubs.sort(key=lambda hub: hub.name)
        shards = await self._list_shards(hubs, seat.plan.names)
        return HubList(
            clustered=True,
            bus=seat.connected,
            epoch=own.epoch,
            hubs=hubs,
            shards=shards,
            problems=find_problems(hubs, shards, bus=seat.connected) + lost,
        )

    async def _list_shards(
        self, hubs: Sequence[HubShape], names: Sequence[str]
    ) -> list[ShardShape]:
        if not names:
            return []
        sites: dict[str, list[str]] = {MAIN: [live.name for live in self._sites]}
        for home in await self._homes.list_homes():
            if home.server in names:
                sites.setdefault(home.server, []).append(home.site)
        leads = {name: hub.name for hub in hubs if hub.role != "gone" for name in hub.shards}
        return [
            ShardShape(name=name, lead=leads.get(name, ""), sites=sites.get(name, []))
            for name in (MAIN, *names)
        ]


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]


def _shape(notice: HubNotice, newest: int, *, own: bool, silent_s: float) -> HubShape:
    # Another hub may lead the main shard: of that one the higher number tells.
    leads_main = notice.leads and notice.epoch == newest
    leads = leads_main or any(shard != MAIN for shard in notice.shards)
    role = "leads" if leads else "waits"
    if notice.leaving:
        role = "leaves"
    if silent_s > SILENT_S:
        role = "gone"
    return HubShape(
        name=notice.name,
        version=notice.version,
        role=role,
        own=own,
        since_us=notice.since_us,
        cpu=notice.cpu,
        memory_bytes=notice.memory_bytes,
        database_ms=notice.database_ms,
        gateways=notice.gateways,
        sockets=notice.sockets,
        # Of the bus that is away: nobody was heard.
        silent_s=min(silent_s, 1e6),
        shards=list(notice.shards),
    )
