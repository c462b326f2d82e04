"""Keeps a forecast of the week for each site that is looked at, made by a process of its own."""

from __future__ import annotations

import asyncio
import contextlib
import heapq
import logging
import os
import sys
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.hub.live.observing.observing_sites import instrument_of, pauses_of
from talaia.hub.observing.forecast_child import ForecastQuestion
from talaia.planner.week import WeekForecast

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from talaia.clock import Clock
    from talaia.hub.store.observing.proposals import ProposalStore
    from talaia.hub.store.observing.request_store import RequestStore
    from talaia.model.site import Site

__all__ = ["ForecastFailed", "ForecastService", "KeptForecast"]

log = logging.getLogger(__name__)

# One that is older is made anew, when somebody looks (s).
_FRESH_S = 600.0
# What was changed shows in the next one, which follows no sooner than this (s), nor than three
# times what the last one took: the rest of the core is for others.
_SOONEST_S = 20.0
_PAUSES = 3.0
# A process that takes longer is ended (s).
_LONGEST_S = 900.0
# Of more groups those of the highest priority are planned: hardly any night reaches the others.
_MOST_GROUPS = 1_000
# What a process needs of our surroundings; secrets of the hub's are not among it.
_SURROUNDINGS = ("PATH", "PYTHONPATH", "LANG", "HOME")
_PLAIN = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1"}


class ForecastFailed(Exception):
    """No forecast could be made.

    Attributes:
        why: in words.

    """

    def __init__(self, why: str) -> None:
        """Fill them in."""
        super().__init__(f"no forecast could be made: {why}")
        self.why = why


class KeptForecast(NamedTuple):
    """A forecast, and of what it was made.

    Attributes:
        week: see `WeekForecast`.
        revision: of the requests that it counts.
        setting: place and instrument.
        ready: when it was there (s since the epoch, UTC).
        took: (s).

    """

    week: WeekForecast
    revision: int
    setting: tuple[object, ...]
    ready: float
    took: float


class ForecastService:
    """One process at a time for all sites; who looks gets the newest there is."""

    def __init__(
        self,
        requests: RequestStore,
        proposals: ProposalStore,
        clock: Clock,
        *,
        ask_child: Callable[[ForecastQuestion], Awaitable[WeekForecast]] | None = None,
    ) -> None:
        """Forecast what is kept in the stores; ``clock`` says from when on."""
        self._requests = requests
        self._proposals = proposals
        self._clock = clock
        self._ask_child = ask_child or _run_child
        self._kept: dict[str, KeptForecast] = {}
        self._failed: dict[str, tuple[float, str]] = {}
        # What is to be made, in the order in which it was asked for.
        self._asked: dict[str, Site] = {}
        self._wake = asyncio.Event()
        self._made = asyncio.Condition()

    async def run(self) -> None:
        """Make what is asked for, one after the other, until cancelled."""
        while True:
            await self._wake.wait()
            if not self._asked:
                self._wake.clear()
                continue
            name = next(iter(self._asked))
            site = self._asked[name]
            try:
                self._kept[name] = await self._make(site)
                self._failed.pop(name, None)
            except (OSError, TimeoutError, ForecastFailed, msgspec.MsgspecError) as error:
                log.warning("%s: no forecast of its nights: %s", name, error)
                self._failed[name] = self._now(), str(error) or type(error).__name__
            finally:
                self._asked.pop(name, None)
                async with self._made:
                    self._made.notify_all()

    async def look_up(self, site: Site) -> KeptForecast | None:
        """Give the newest forecast; a newer one is begun where it is time for it.

        Raises:
            StoreDown: what waits cannot be read.

        """
        kept = self._kept.get(site.site)
        if kept is None or await self._is_old(site, kept):
            failed = self._failed.get(site.site)
            if failed is None or self._now() - failed[0] > _SOONEST_S:
                self._asked.setdefault(site.site, site)
                self._wake.set()
        return kept

    async def wait_for(self, site: Site, seconds: float) -> KeptForecast | None:
        """Give the newest forecast; without any wait so long for the first one.

        Raises:
            ForecastFailed: it could not be made.
            StoreDown: what waits cannot be read.

        """
        kept = await self.look_up(site)
        if kept is not None:
            return kept
        await self.wait_made(site, seconds)
        kept = self._kept.get(site.site)
        failed = self._failed.get(site.site)
        if kept is None and failed is not None:
            raise ForecastFailed(failed[1])
        return kept

    async def wait_made(self, site: Site, seconds: float) -> None:
        """Wait so long at the most until none is under way for a site."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(seconds), self._made:
                await self._made.wait_for(lambda: site.site not in self._asked)

    def is_pending(self, site: str) -> bool:
        """Tell whether a newer one is being made, or waits for its turn."""
        return site in self._asked

    async def _is_old(self, site: Site, kept: KeptForecast) -> bool:
        age = self._now() - kept.ready
        if age > _FRESH_S or kept.setting != _setting_of(site):
            return True
        # The night of before is no forecast.
        if self._now() > kept.week.nights[0].plan.night_end:
            return True
        if age < max(_SOONEST_S, _PAUSES * kept.took):
            return False
        return await self._requests.newest_revision(site.site) != kept.revision

    async def _make(self, site: Site) -> KeptForecast:
        place = site.place
        if place is None:
            raise ForecastFailed("the description does not say where the site is")
        pending = await self._requests.pending_set(site.site)
        proposals = [one.planned() for one in await self._proposals.list_proposals(site.site)]
        groups = (one.group for one in pending.groups)
        began = self._now()
        asked = ForecastQuestion(
            latitude=place.latitude,
            longitude=place.longitude,
            elevation=place.elevation or 0.0,
            now=began,
            instrument=instrument_of(site),
            pauses=pauses_of(site),
            proposals=tuple(proposals),
            groups=tuple(heapq.nlargest(_MOST_GROUPS, groups, key=lambda group: group.priority)),
        )
        async with asyncio.timeout(_LONGEST_S):
            week = await self._ask_child(asked)
        ready = self._now()
        return KeptForecast(week, pending.revision, _setting_of(site), ready, ready - began)

    def _now(self) -> float:
        return self._clock.wall_ns() / 1e9


def _setting_of(site: Site) -> tuple[object, ...]:
    return site.place, instrument_of(site)


async def _run_child(asked: ForecastQuestion) -> WeekForecast:
    kept = {name: os.environ[name] for name in _SURROUNDINGS if name in os.environ}
    child = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "talaia.hub.observing.forecast_child"),
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
        env={**kept, **_PLAIN},
    )
    try:
        answer, said = await child.communicate(msgspec.msgpack.encode(asked))
    finally:
        if child.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                child.kill()
            await child.wait()
    if child.returncode:
        last = said.decode("utf-8", "replace").strip().rpartition("\n")[2]
        raise ForecastFailed(last[:300] or f"its process ended with {child.returncode}")
    return msgspec.msgpack.decode(answer, type=WeekForecast)
