"""Gateways that store at the same time do so together, and leave the loop's turns to others."""

from __future__ import annotations

import asyncio

from talaia.hub.live.gateways.ingest import StoringPace


async def test_hundreds_that_have_something_to_store_begin_together_and_not_in_one_turn() -> None:
    pace, events = StoringPace(0.001), [asyncio.Event() for _ in range(200)]
    for event in events:
        pace.set_soon(event)
    turns = []
    while not all(event.is_set() for event in events):
        await asyncio.sleep(0)
        turns.append(sum(event.is_set() for event in events))
    # In the order in which they came, some in each turn: whoever drives is in between.
    begun = [now - before for before, now in zip([0, *turns], turns, strict=False)]
    assert max(begun) < 100
    assert sum(begun) == 200


async def test_who_comes_after_all_have_begun_is_not_forgotten() -> None:
    pace = StoringPace(0.001)
    for _ in range(3):
        event = asyncio.Event()
        pace.set_soon(event)
        await event.wait()
