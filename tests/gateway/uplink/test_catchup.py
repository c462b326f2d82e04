"""Catching up: what waited goes out in order, and what the hub asks for again goes out anew."""

from __future__ import annotations

import asyncio
from pathlib import Path

import numpy as np

from talaia.gateway.samples.batching import records_of
from talaia.gateway.spool import packing
from talaia.gateway.spool.journal import SegmentHead, Spool
from talaia.gateway.spool.sizes import USUAL, SpoolSizes
from talaia.gateway.spool.spool_thread import SpoolThread
from talaia.gateway.uplink import catchup
from talaia.gateway.uplink.catchup import CatchUp
from talaia.gateway.uplink.send_lanes import SendLanes
from talaia.wire.columns import Columns
from talaia.wire.frames import LINK_FROM_GATEWAY, SampleBatch, StopState

BATCHES, SIZE = 40, 10


def keeper_of(folder: Path, batches: int = BATCHES, sizes: SpoolSizes = USUAL) -> SpoolThread:
    spool = Spool(folder=folder, head=SegmentHead("b", "c", ["base/v"]), bound=1 << 30, sizes=sizes)
    for number in range(batches):
        first = number * SIZE
        columns = Columns(
            np.zeros(SIZE, np.uint16), first + np.arange(SIZE), np.arange(SIZE) * 1.0, {}
        )
        (record,) = records_of(columns, "b", "c", first)
        spool.append_record(record)
    return SpoolThread(spool)


async def sent(lanes: SendLanes, count: int) -> list[int]:
    """Take so many old batches out as the writer does; give their first samples."""
    found: list[int] = []
    async with asyncio.timeout(10):
        while len(found) < count:
            data = lanes.next()
            if data is None:
                await asyncio.sleep(0.005)
                continue
            frame = LINK_FROM_GATEWAY.decode(data)
            assert isinstance(frame, SampleBatch)
            assert not frame.live
            found.append(frame.first)
    return found


async def test_what_the_hub_asks_for_again_is_sent_again_and_no_more(tmp_path: Path) -> None:
    keeper, lanes = keeper_of(tmp_path), SendLanes(lambda: None)
    lanes.link_up()
    running = asyncio.ensure_future(
        CatchUp(spool=keeper, lanes=lanes, boot="b", catalogue=lambda: "c", rate=10_000_000).run(
            BATCHES * SIZE
        )
    )
    assert await sent(lanes, BATCHES) == [*range(0, BATCHES * SIZE, SIZE)]
    lanes.owe("b", 105, 121)
    assert await sent(lanes, 3) == [100, 110, 120]
    assert lanes.next() is None
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)
    await keeper.close()


async def test_what_was_packed_is_not_sent_at_one_blow(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(packing, "FRAME_SAMPLES", 500)
    batches, rate = 2500, 40_000
    sizes = SpoolSizes(segment=300_000)
    keeper, lanes = keeper_of(tmp_path, batches, sizes), SendLanes(lambda: None)
    lanes.link_up()
    running = asyncio.ensure_future(
        CatchUp(spool=keeper, lanes=lanes, boot="b", catalogue=lambda: "c", rate=rate).run(
            batches * SIZE
        )
    )
    loop = asyncio.get_running_loop()
    began, got, largest = loop.time(), 0, 0
    while loop.time() - began < 1.5:
        data = lanes.next()
        if data is None:
            await asyncio.sleep(0.005)
        else:
            got, largest = got + len(data), max(largest, len(data))
            # At no time more than its rate, and the piece that is due.
            assert got <= rate * (loop.time() - began) + rate * catchup.STEP_S + 2 * largest
    assert got > rate / 4
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)
    await keeper.close()


async def test_old_samples_wait_while_the_hub_stores_nothing_and_stop_never_waits(
    tmp_path: Path,
) -> None:
    keeper, lanes = keeper_of(tmp_path), SendLanes(lambda: None)
    lanes.link_up()
    running = asyncio.ensure_future(
        CatchUp(
            spool=keeper,
            lanes=lanes,
            boot="b",
            catalogue=lambda: "c",
            rate=20_000,
            most_unheard=1000,
        ).run(BATCHES * SIZE)
    )
    taken = 0
    # Long enough for all of them at this rate.
    until = asyncio.get_running_loop().time() + 1.5
    while asyncio.get_running_loop().time() < until:
        taken += lanes.next() is not None
        await asyncio.sleep(0.002)
    assert 0 < taken < BATCHES // 2
    lanes.send(StopState(device="base", latched=True))
    data = lanes.next()
    assert data is not None
    assert isinstance(LINK_FROM_GATEWAY.decode(data), StopState)
    # It stores again.
    lanes.acks += 1
    await sent(lanes, 1)
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)
    await keeper.close()
