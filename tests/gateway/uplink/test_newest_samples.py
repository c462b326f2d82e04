"""A gateway knows the newest sample of every channel, of this run and of one that was killed."""

from __future__ import annotations

import asyncio
from pathlib import Path

import numpy as np
import pytest

from talaia.clock import HandClock
from talaia.gateway.samples.batching import Batcher, records_of
from talaia.gateway.spool.journal import SegmentHead, Spool
from talaia.gateway.spool.sizes import SpoolSizes
from talaia.gateway.spool.spool_thread import SpoolThread
from talaia.gateway.uplink.catchup import CatchUp
from talaia.gateway.uplink.newest_samples import NewestSamplesSender
from talaia.gateway.uplink.send_lanes import SendLanes
from talaia.wire.columns import Columns
from talaia.wire.frames import LINK_FROM_GATEWAY, NewestBatch, SampleBatch
from talaia.wire.newest import newest_of

pytestmark = pytest.mark.pure

ADDRESSES = ["a/x", "a/y", "a/z"]


def columns(*rows: tuple[int, int, float], texts: dict[int, str] | None = None) -> Columns:
    return Columns(
        np.array([row[0] for row in rows], np.uint16),
        np.array([row[1] for row in rows], np.int64),
        np.array([row[2] for row in rows], np.float64),
        texts or {},
    )


def read(data: bytes | None) -> dict[int, tuple[int, float]]:
    """Give what is told, by channel: number and value."""
    assert data is not None
    message = LINK_FROM_GATEWAY.decode(data)
    assert isinstance(message, NewestBatch)
    told = newest_of(message)
    rows = zip(
        told.columns.channel.tolist(), told.sequence.tolist(), told.columns.value.tolist(),
        strict=True,
    )  # fmt: skip
    return {channel: (number, value) for channel, number, value in rows}


async def test_newest_of_this_run_goes_by_the_channel_list_that_counts_now() -> None:
    batcher = Batcher(
        loop=asyncio.get_running_loop(),
        boot="b",
        catalogue="c",
        flush=60.0,
        keep=lambda _: None,
        lose=lambda *_: None,
    )
    batcher.put_samples(columns((0, 1, 1.0), (1, 2, 2.0), (0, 3, 3.0)))
    batcher.put_samples(columns((2, 4, np.nan), texts={0: "open"}))
    batcher.flush_batches()
    told = batcher.newest_samples()
    assert told.columns.channel.tolist() == [1, 0, 2]
    assert told.sequence.tolist() == [1, 2, 3]
    assert told.columns.texts == {2: "open"}
    assert (told.age_ms >= 0).all()
    # The second is described no more, and the third has become the first.
    batcher.redescribe("d", np.array([1, -1, 0], np.int64))
    told = batcher.newest_samples()
    assert told.columns.channel.tolist() == [1, 0]
    assert told.columns.texts == {1: "open"}


def killed(folder: Path, runs: int) -> None:
    """Leave what runs of a gateway leave that were killed: the first said all, the later ones x."""
    sizes = SpoolSizes(segment=1200)
    for run in range(runs):
        boot = f"boot-{run}"
        head = SegmentHead(boot, "c", ADDRESSES)
        spool = Spool(folder=folder, head=head, bound=1 << 30, sizes=sizes)
        for number in range(30):
            rows = [(0, number, run * 100.0 + number)]
            if run == 0 and number == 3:
                rows.append((2, number, 11.0))
            (record,) = records_of(columns(*rows), boot, "c", spool_end(number, run))
            spool.append_record(record)


def spool_end(number: int, run: int) -> int:
    """One sample a batch, and one more in the fourth of the first run."""
    return number + (1 if run == 0 and number > 3 else 0)


async def test_newest_of_runs_that_were_killed_is_found_behind_all_that_is_older(
    tmp_path: Path,
) -> None:
    killed(tmp_path, 2)
    batcher = Batcher(
        loop=asyncio.get_running_loop(),
        boot="boot-9",
        catalogue="c",
        flush=60.0,
        keep=lambda _: None,
        lose=lambda *_: None,
    )
    keeper, lanes = (
        SpoolThread(
            Spool(folder=tmp_path, head=SegmentHead("boot-9", "c", ADDRESSES), bound=1 << 30)
        ),
        SendLanes(lambda: None),
    )
    lanes.link_up()
    teller = NewestSamplesSender(
        newest=batcher.newest_samples, spool=keeper, lanes=lanes, clock=HandClock(), boot="boot-9"
    )
    for _ in range(2):  # the second time from memory
        await teller.tell_former(lambda: ADDRESSES)
        told = [LINK_FROM_GATEWAY.decode(data) for data in iter(lanes.next, None)]
        found = {
            message.addresses[channel]: (message.boot, number, value)
            for message in told
            if isinstance(message, NewestBatch)
            for channel, number, value in zip(
                newest_of(message).columns.channel.tolist(),
                newest_of(message).sequence.tolist(),
                newest_of(message).columns.value.tolist(),
                strict=True,
            )
        }
        assert found == {"a/x": ("boot-1", 29, 129.0), "a/z": ("boot-0", 4, 11.0)}
    # What this run has heard itself is not asked of former ones.
    batcher.put_samples(columns((2, 50, 12.0)))
    batcher.flush_batches()
    await teller.tell_former(lambda: ADDRESSES)
    (message,) = [LINK_FROM_GATEWAY.decode(data) for data in iter(lanes.next, None)]
    assert isinstance(message, NewestBatch)
    assert [message.addresses[at] for at in newest_of(message).columns.channel] == ["a/x"]
    await keeper.close()


async def test_newest_goes_before_what_is_heard_after_it_and_is_told_again_when_live_ones_go(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(SendLanes, "MAX_LIVE", 600)
    lanes = SendLanes(lambda: None)
    keeper = SpoolThread(
        Spool(folder=tmp_path, head=SegmentHead("b", "c", ADDRESSES), bound=1 << 30)
    )
    batcher = Batcher(
        loop=asyncio.get_running_loop(), boot="b", catalogue="c", flush=60.0,
        keep=lambda record: lanes.live(record.body, record.first, record.end), lose=lambda *_: None,
    )  # fmt: skip
    teller = NewestSamplesSender(
        newest=batcher.newest_samples, spool=keeper, lanes=lanes, clock=HandClock(), boot="b"
    )
    batcher.put_samples(columns((2, 1, 11.0)))
    batcher.flush_batches()
    lanes.link_up()
    teller.tell_run("c")
    batcher.put_samples(columns((0, 2, 1.0)))
    batcher.flush_batches()
    assert read(lanes.next()) == {2: (0, 11.0)}
    data = lanes.next()
    assert data is not None
    assert isinstance(LINK_FROM_GATEWAY.decode(data), SampleBatch)
    # Said once, and then so much of others that the lane is emptied.
    batcher.put_samples(columns((1, 3, 5.0)))
    batcher.flush_batches()
    for at in range(20):
        batcher.put_samples(columns((0, 10 + at, 1.0 * at)))
        batcher.flush_batches()
    assert lanes.overflowed is not None
    catchup = CatchUp(
        spool=keeper,
        lanes=lanes,
        boot="b",
        catalogue=lambda: "c",
        rate=10**6,
        dropped=lambda: teller.tell_run("c"),
    )
    running = asyncio.ensure_future(catchup.run(batcher.next))
    async with asyncio.timeout(10):
        while lanes.overflowed is not None:  # noqa: ASYNC110 - looked at once a second
            await asyncio.sleep(0.01)
    told = [LINK_FROM_GATEWAY.decode(data) for data in iter(lanes.next, None)]
    (message,) = [each for each in told if isinstance(each, NewestBatch)]
    assert newest_of(message).columns.value.tolist() == [11.0, 5.0, 19.0]
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)
    await keeper.close()
