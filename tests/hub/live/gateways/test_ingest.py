"""Samples of a gateway on their way to the history: what comes together is stored together."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from talaia.hub.live.gateways.ingest import Batch, Ingest, StoringPace
from talaia.wire.columns import Columns
from talaia.wire.frames import Ack, ResendRequest

if TYPE_CHECKING:
    from talaia.hub.ports import History

ADDRESSES = ("base/a",)


class SlowHistory:
    """A history that takes a few turns of the loop for each commit."""

    def __init__(self) -> None:  # noqa: D107
        # The first number and the length of each piece.
        self.stored: list[tuple[int, int]] = []
        self.began = asyncio.Event()

    async def stored_below(self, _site: str, _boot: str) -> int:
        return 0

    async def append_samples(
        self, _site: str, _boot: str, first: int, *, columns: Columns, **_: Any
    ) -> None:
        for _ in range(3):
            await asyncio.sleep(0)
        self.stored.append((first, len(columns)))
        self.began.set()


def batch(first: int, count: int = 1) -> Batch:
    zeros = np.zeros(count)
    columns = Columns(zeros.astype(np.uint16), zeros.astype(np.int64), zeros, {})
    return Batch("run", first, ADDRESSES, columns)


async def feed(ingest: Ingest, count: int, size: int = 1) -> None:
    """Say a batch in each turn of the loop."""
    for number in range(count):
        ingest.enqueue_batch(batch(number * size, size))
        await asyncio.sleep(0)


async def test_who_catches_up_is_stored_without_gathering() -> None:
    history, all_told = SlowHistory(), asyncio.Event()

    def tell(said: object) -> None:
        if said == Ack(boot="run", below=400_000):
            all_told.set()

    # Nothing that is gathered for so long is stored in a test.
    ingest = Ingest(cast("History", history), "site", tell, StoringPace(3600.0))
    storing = asyncio.create_task(ingest.run())
    # More than a commit holds.
    await feed(ingest, 20, 20_000)
    await all_told.wait()
    storing.cancel()
    assert sum(count for _, count in history.stored) == 400_000
    assert len(history.stored) > 1


class HandPace(StoringPace):
    """It is time to store when a test says so."""

    def __init__(self) -> None:  # noqa: D107
        super().__init__(3600.0)
        self.asked: list[asyncio.Event] = []

    def set_soon(self, event: asyncio.Event) -> None:
        self.asked.append(event)


async def test_what_comes_within_a_commit_is_gathered_for_the_next_one() -> None:
    history, told, pace = SlowHistory(), asyncio.Queue[Ack | ResendRequest](), HandPace()
    ingest = Ingest(cast("History", history), "site", told.put_nowait, pace)
    storing = asyncio.create_task(ingest.run())
    await feed(ingest, 3)
    pace.asked.pop().set()
    # Into its commit, which takes a few turns.
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    for number in (3, 4):
        ingest.enqueue_batch(batch(number))
    assert await told.get() == Ack(boot="run", below=3)
    for _ in range(20):
        await asyncio.sleep(0)
    assert history.stored == [(0, 3)]
    # Asked for once, though two came.
    pace.asked.pop().set()
    assert pace.asked == []
    assert await told.get() == Ack(boot="run", below=5)
    assert history.stored == [(0, 3), (3, 2)]
    storing.cancel()


async def test_the_end_stores_what_waits_without_gathering() -> None:
    history, told = SlowHistory(), []
    ingest = Ingest(cast("History", history), "site", told.append, StoringPace(0.05))
    await feed(ingest, 5)
    ingest.finish_storing()
    await ingest.run()
    assert told == [Ack(boot="run", below=5)]


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
