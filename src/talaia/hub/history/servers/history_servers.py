"""The history on several servers, as the rest of the hub sees it: each site is on one of them.

Long, because all that `History` promises is led on from here. A site that moves is written where
it was until the one commit that says otherwise; from a moment before to a moment after it, what
comes waits, and is not acknowledged.
"""

from __future__ import annotations

import asyncio
import contextlib
from typing import TYPE_CHECKING, TypeVar

from talaia.hub.errors import CannotStart
from talaia.hub.history.errors import HistoryAway, HistoryError
from talaia.hub.history.servers.history_server import STILL_S, HistoryServer
from talaia.hub.history.servers.late_descriptions import LateDescriptions
from talaia.hub.history.servers.site_moves import SiteMoves
from talaia.hub.history.servers.site_places import SitePlaces
from talaia.hub.history.storage import join_storage
from talaia.hub.store.history_servers.home_tables import OWN

if TYPE_CHECKING:
    from collections.abc import (
        AsyncGenerator,
        AsyncIterator,
        Awaitable,
        Collection,
        Mapping,
        Sequence,
    )

    from talaia.clock import Clock
    from talaia.hub.history.limits import HistoryLimits
    from talaia.hub.history.queries.channels import StoredChannel
    from talaia.hub.history.queries.export_formats import ExportColumn, FileForm
    from talaia.hub.history.queries.outliers import Outliers
    from talaia.hub.history.queries.series import Series
    from talaia.hub.history.queries.statistics import Statistics
    from talaia.hub.history.sensors.sensor_views import StoredSensorKind
    from talaia.hub.history.servers.server_file import HistoryServersFile
    from talaia.hub.history.servers.shard_passage import ShardPassage
    from talaia.hub.history.storage import Storage
    from talaia.hub.history.store import HistoryStore
    from talaia.hub.store.history_servers.history_homes import HistoryHomes
    from talaia.model.site import Site
    from talaia.wire.columns import Columns

__all__ = ["HistoryServers"]

ResultT = TypeVar("ResultT")
# Between two looks at servers that are away, and at moves that were asked for (s).
_LOOK_S = 2.0
# A gateway's hello waits so long for a server that stands still (s).
_PATIENCE_S = 3.0


class HistoryServers:
    """Each site on the server that the accounts' database says; `run` mends and moves.

    Attributes:
        places: where each site is.
        descriptions: what is known of sites, and their servers are told.

    """

    def __init__(
        self,
        own: HistoryStore | None,
        named: HistoryServersFile,
        homes: HistoryHomes,
        *,
        clock: Clock,
        limits: HistoryLimits,
        still_s: float = STILL_S,
        shard: str | None = None,
        passage: ShardPassage | None = None,
    ) -> None:
        """Have ``own``, the hub's own database, and those that are ``named``.

        Args:
            own: of a shard other than the main one, none.
            named: the file of servers.
            homes: which has which site.
            clock: the time.
            limits: of each of them.
            still_s: one that does not answer for so long is away.
            shard: have this one's servers alone; none: have all.
            passage: by which sites go to other shards, and come; none: they do not.

        Raises:
            HistoryError: a URL cannot be read, or its driver is not installed.

        """
        self._own = own
        self._named, self._homes, self._limits = named, homes, limits
        self._servers = {
            name: HistoryServer(name, url, clock=clock, limits=limits, homes=homes, still_s=still_s)
            for name, url in named.servers.items()
            if shard in (None, named.plan.shard_of_server(name))
        }
        # Which of them has which site.
        self.places = SitePlaces(own, self._servers, named, homes, shard=shard)
        self.descriptions = LateDescriptions(self.places)
        self._passage = passage
        arrivals = passage and passage.make_arrivals(self.places, self.descriptions, homes, named)
        self._moves = SiteMoves(self.places, self.descriptions, homes, arrivals)

    async def open(self) -> None:
        """Open the hub's own database; others are opened when they are there.

        Raises:
            HistoryError: the hub's own database cannot be opened.
            CannotStart: a site is on a server that is not named.

        """
        if self._own is not None:
            await self._own.open()
        if self._passage is not None:
            # Before anything is written: what the lead of before held is held no more.
            await self._passage.handover.end_holds(self.places.list_servers())
        for home in await self._homes.list_homes():
            for name in (home.server, home.moving_to, home.erase_at):
                if name not in {"", OWN, *self._named.servers}:
                    raise CannotStart(
                        f"the history of {home.site} is on the server {name!r}, which"
                        " --history-servers does not name",
                        "name it there again",
                    )
            self.places.home_of[home.site] = home.server
            self._moves.hold_retention(home)
        await asyncio.gather(*(server.try_open() for server in self._servers.values()))

    async def close(self) -> None:
        """Let go of everything; what was appended is already safe."""
        for server in self._servers.values():
            await server.close()
        if self._own is not None:
            await self._own.close()

    async def run(self) -> None:
        """Open servers that come back, and move sites that are asked to move, until cancelled."""
        async with asyncio.TaskGroup() as group:
            # Each by itself: one that stands still holds up no other.
            for server in self._servers.values():
                group.create_task(self._keep_server(server), name=f"keep {server.name}")
            group.create_task(self._keep_moving(), name="move sites")
            if self._passage is not None:
                holds = self._passage.make_holds(self.places, self._homes)
                group.create_task(holds.run(), name="answer other shards")

    async def mend_servers(self) -> None:
        """Open servers that have come back, and describe to them what came meanwhile."""
        await asyncio.gather(*map(self._mend_server, self._servers.values()))
        await self.descriptions.describe_late(OWN)

    async def _keep_server(self, server: HistoryServer) -> None:
        while True:
            await self._mend_server(server)
            await asyncio.sleep(_LOOK_S)

    async def _keep_moving(self) -> None:
        while True:
            await self.move_sites()
            await self.descriptions.describe_late(OWN)
            await asyncio.sleep(_LOOK_S)

    async def _mend_server(self, server: HistoryServer) -> None:
        await server.check_pulse()
        await server.try_open()
        await self.descriptions.describe_late(server.name)

    async def move_sites(self) -> None:
        """Go on with each move that was asked for, once; what fails is tried again later."""
        await self._moves.move_sites()

    # ── what `History` promises ──

    async def describe_site(self, site: Site) -> None:
        """See `History.describe_site`; while its server is away, it is done later."""
        await self.descriptions.describe_site(site)

    async def wait_for_views(self) -> None:
        """Wait for the SQL views of all that was described so far, on servers that are there."""
        stores = self.places.open_stores()
        await asyncio.gather(*(store.wait_for_views() for store in stores))

    async def rename_channels(self, site: str, moves: Mapping[str, str]) -> None:
        """See `History.rename_channels`.

        Raises:
            HistoryAway: its server is away; nothing is renamed.

        """
        if not moves:
            return
        if self.places.is_held(site):
            raise HistoryAway(f"the history of {site} is being moved")
        async with self.places.describing_turn(site):
            store = self.places.store_named(await self.places.find_home(site))
            await self._with_patience(site, store.rename_channels(site, moves))

    async def append_samples(
        self, site: str, boot: str, first: int, *, addresses: Sequence[str], columns: Columns
    ) -> None:
        """See `History.append_samples`."""
        store = await self.places.writing_store(site)
        await store.append_samples(site, boot, first, addresses=addresses, columns=columns)

    async def record_gap(
        self,
        site: str,
        boot: str,
        first: int,
        last: int,
        *,
        from_us: int,
        to_us: int,
        reason: str,
    ) -> None:
        """See `History.record_gap`."""
        store = await self.places.writing_store(site)
        await store.record_gap(site, boot, first, last, from_us=from_us, to_us=to_us, reason=reason)

    async def stored_below(self, site: str, boot: str) -> int:
        """See `History.stored_below`.

        Raises:
            HistoryAway: its server is away.

        """
        # Within a move, too: until its commit the old place has all, and after it the new one.
        store = self.places.store_named(await self.places.find_home(site))
        return await self._with_patience(site, store.stored_below(site, boot))

    def has_channel(self, site: str, address: str) -> bool:
        """See `History.has_channel`.

        Raises:
            HistoryAway: its server is away.

        """
        return self.places.store_of(site).has_channel(site, address)

    async def read_series(
        self,
        site: str,
        addresses: Sequence[str],
        from_us: int,
        to_us: int,
        *,
        width: int,
        steps: Collection[str] = (),
    ) -> list[Series]:
        """See `History.read_series`."""
        with self.places.reading(site) as store:
            return await store.read_series(
                site, addresses, from_us, to_us, width=width, steps=steps
            )

    async def last_readings(
        self, site: str, addresses: Sequence[str], to_us: int = 2**62
    ) -> dict[str, tuple[int, float, str]]:
        """See `History.last_readings`."""
        with self.places.reading(site) as store:
            return await store.last_readings(site, addresses, to_us)

    async def read_statistics(
        self, site: str, addresses: Sequence[str], from_us: int, to_us: int
    ) -> list[Statistics]:
        """See `History.read_statistics`."""
        with self.places.reading(site) as store:
            return await store.read_statistics(site, addresses, from_us, to_us)

    async def count_outliers(
        self, site: str, address: str, from_us: int, to_us: int, *, k: float
    ) -> AsyncGenerator[Outliers | None]:
        """See `History.count_outliers`."""
        with self.places.reading(site) as store:
            found = store.count_outliers(site, address, from_us, to_us, k=k)
            async with contextlib.aclosing(found):
                async for part in found:
                    yield part

    def kind_of(self, site: str, address: str) -> StoredSensorKind | None:
        """See `History.kind_of`; none while its server is away."""
        store = self.places.opened_store(site)
        return None if store is None else store.kind_of(site, address)

    async def list_channels(self, site: str, without: Collection[str] = ()) -> list[StoredChannel]:
        """See `History.list_channels`."""
        with self.places.reading(site) as store:
            return await store.list_channels(site, without)

    async def measure_storage(self) -> Storage:
        """See `History.measure_storage`; servers that are away are left out.

        Raises:
            HistoryAway: none is there.

        """
        found = [] if self._own is None else [await self._own.measure_storage()]
        for server in self._servers.values():
            with contextlib.suppress(HistoryError):
                found.append(await server.use_store().measure_storage())
        if not found:
            raise HistoryAway(self.trouble or "no server is there")
        return join_storage(found)

    @property
    def cached_bytes(self) -> int:
        """See `History.cached_bytes`."""
        return sum(store.cached_bytes for store in self.places.open_stores())

    @property
    def trouble(self) -> str:
        """Why not all can be stored at present; empty while all is well."""
        if self._own is not None and self._own.trouble:
            return self._own.trouble
        for name, server in self._servers.items():
            store = server.opened
            why = server.why if store is None else store.trouble
            away = sorted(site for site, home in self.places.home_of.items() if home == name)
            if why and away:
                return f"the history of {', '.join(away)} is on {name!r}, which is away: {why}"
        return ""

    @property
    def most_bytes(self) -> int:
        """See `History.most_bytes`; each server may take so many."""
        return self._limits.bytes * (len(self._servers) + (self._own is not None))

    def kept_us(self, site: str, address: str) -> int:
        """See `History.kept_us`."""
        store = self.places.opened_store(site)
        return 0 if store is None else store.kept_us(site, address)

    async def export_samples(
        self,
        site: str,
        columns: Sequence[ExportColumn],
        from_us: int,
        to_us: int,
        *,
        form: FileForm,
        width: int = 0,
    ) -> AsyncIterator[bytes]:
        """See `History.export_samples`."""
        with self.places.reading(site) as store:
            parts = store.export_samples(site, columns, from_us, to_us, form=form, width=width)
            async for part in parts:
                yield part

    async def _with_patience(self, site: str, asked: Awaitable[ResultT]) -> ResultT:
        if self.places.home_of.get(site, OWN) == OWN:
            return await asked
        try:
            async with asyncio.timeout(_PATIENCE_S):
                return await asked
        except (HistoryError, TimeoutError) as error:
            why = str(error) or "it stands still"
            raise HistoryAway(f"the server of the history of {site} is away: {why}") from error
