"""Forecasts of the week: made beside the loop, kept while they are good, and no sooner again."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from talaia.clock import SECOND, HandClock
from talaia.hub.live.observing.forecast_service import ForecastFailed, ForecastService
from talaia.hub.observing.forecast_child import ForecastQuestion
from talaia.hub.store.observing.request_queries import PendingSet
from talaia.model.observing.plan import Plan
from talaia.model.yaml_text.load import load_site
from talaia.planner.week import NightForecast, WeekForecast

EXAMPLES = Path(__file__).parents[4] / "examples"
SITE = load_site((EXAMPLES / "observatory" / "site.yaml").read_text())
MINUTE = 60 * SECOND
HOUR = 60 * MINUTE


class Store:
    """Requests and proposals of no rows, with a revision that is moved by hand."""

    revision = 1

    async def pending_set(self, site: str) -> PendingSet:
        return PendingSet(self.revision, [])

    async def newest_revision(self, site: str) -> int:
        return self.revision

    async def list_proposals(self, site: str) -> list:
        return []


class Child:
    """Answers when it is let, and counts what it is asked."""

    def __init__(self, clock: HandClock) -> None:  # noqa: D107
        self.clock = clock
        self.asked: list[ForecastQuestion] = []
        self.fails = False
        self.free = asyncio.Event()
        self.free.set()

    async def answer(self, asked: ForecastQuestion) -> WeekForecast:
        self.asked.append(asked)
        await self.free.wait()
        if self.fails:
            raise ForecastFailed("its process ended with 1")
        end = asked.now + 10 * 3600.0
        plan = Plan(made_at=asked.now, night_start=asked.now, night_end=end)
        night = NightForecast(plan=plan, chances={})
        return WeekForecast(made_at=asked.now, open_share=0.7, nights=(night,), reasons=())


@asynccontextmanager
async def serving():
    clock, store = HandClock(), Store()
    child = Child(clock)
    service = ForecastService(store, store, clock, ask_child=child.answer)  # type: ignore[arg-type]
    task = asyncio.create_task(service.run())
    try:
        yield service, store, child, clock
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


async def settled(service: ForecastService):
    """Give the forecast once nothing is under way."""
    await service.wait_made(SITE, 30.0)
    return await service.look_up(SITE)


async def test_the_first_is_waited_for_and_then_kept_until_something_changes() -> None:
    async with serving() as (service, store, child, clock):
        assert await service.look_up(SITE) is None
        first = await service.wait_for(SITE, 30.0)
        assert first is not None
        assert await service.wait_for(SITE, 30.0) is first
        clock.advance(MINUTE)
        assert await settled(service) is first
        # What changes shows soon, and meanwhile the old one is given at once.
        store.revision = 2
        assert await service.look_up(SITE) is first
        second = await settled(service)
        assert second is not first
        assert len(child.asked) == 2
        # Not with every change, though.
        store.revision = 3
        assert await service.look_up(SITE) is second
        assert not service.is_pending(SITE.site)


async def test_who_waits_too_long_is_told_that_there_is_none_yet() -> None:
    async with serving() as (service, _, child, _):
        child.free.clear()
        assert await service.wait_for(SITE, 0.0) is None
        assert service.is_pending(SITE.site)
        child.free.set()
        assert await service.wait_for(SITE, 30.0) is not None


async def test_a_process_that_fails_is_said_and_not_begun_again_at_once() -> None:
    async with serving() as (service, _, child, clock):
        child.fails = True
        with pytest.raises(ForecastFailed, match="ended with 1"):
            await service.wait_for(SITE, 30.0)
        with pytest.raises(ForecastFailed):
            await service.wait_for(SITE, 30.0)
        assert len(child.asked) == 1
        child.fails = False
        clock.advance(MINUTE)
        assert await service.wait_for(SITE, 30.0) is not None


async def test_a_night_that_is_over_is_no_forecast() -> None:
    async with serving() as (service, _, _, clock):
        first = await service.wait_for(SITE, 30.0)
        clock.advance(11 * HOUR)
        await service.look_up(SITE)
        assert await settled(service) is not first
