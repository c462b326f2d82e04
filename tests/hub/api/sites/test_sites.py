"""The list of all sites keeps nobody waiting who drives."""

from __future__ import annotations

import asyncio
from itertools import pairwise

from talaia.hub.api.sites.sites import SitePages


async def test_others_are_served_between_two_sites_of_a_list() -> None:
    pages = SitePages(sites=["a", "b", "c"], shown=None, audit=None, sightings=None, clock=None)
    turns: list[str] = []

    async def drive() -> None:
        while True:
            turns.append("driver")
            await asyncio.sleep(0)

    driver = asyncio.create_task(drive())
    async for site in pages._site_by_site():
        turns.append(site)  # noqa: PERF401 - in the order of the turns
    driver.cancel()
    assert [turn for turn in turns if turn != "driver"] == ["a", "b", "c"]
    # Never two sites without a turn of somebody else between them.
    assert all("driver" in pair for pair in pairwise(turns))
