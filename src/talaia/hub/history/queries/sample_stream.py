"""All samples of a channel, in order of time, a piece at a time.

A database transaction lasts for one piece only: one that stays open while a slow reader takes an
hour over a download would keep SQLite's journal from being emptied. Blocks never change, and
memory is looked at once before the first of them, so the pieces fit each other all the same.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import and_, or_, select

from talaia.hub.history.blocks.block import (
    EMPTY,
    BlockSamples,
    LastTimes,
    concatenate_samples,
    in_order,
)
from talaia.hub.history.queries.block_run import read_run
from talaia.hub.history.queries.window import FARTHEST_US, read_blocks
from talaia.hub.history.queries.window_query import window_of
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Iterator

    from sqlalchemy import Engine

    from talaia.hub.history.writing.block_index import BlockIndex

__all__ = ["SampleChunk", "stream_samples"]

# Blocks of a piece: what is held at once is a few times as much.
AT_ONCE = 16
_block = tables.block
# Larger than every block's id: memory holds what came after them.
_TAIL = 2**63 - 1


class SampleChunk(NamedTuple):
    """Samples in order of time; none that is still to come lies before ``past_us``."""

    samples: BlockSamples
    past_us: int


def stream_samples(
    engine: Engine,
    ledger: BlockIndex,
    *,
    site: str,
    address: str,
    from_us: int,
    to_us: int,
    last: LastTimes | None = None,
) -> Iterator[SampleChunk]:
    """Give a channel's samples of a window, both ends included; memory is looked at now.

    Samples with one time stamp come in the order in which they were stored. Channels that are
    read in turn share the times that were read ``last``.
    """
    shared = last or LastTimes()
    found = window_of(ledger, site=site, address=address, from_us=from_us, to_us=to_us)
    if found is None:
        return iter(())
    window, held = found
    tail = in_order(held).between_times(window.from_us, window.to_us)

    def pieces() -> Iterator[SampleChunk]:
        # What was read and is not given yet, by block: later blocks may lie among it.
        waiting: dict[int, BlockSamples] = {_TAIL: tail} if tail.time_us.size else {}
        after = (-(2**63), 0)
        more = True
        while more:
            query = (
                select(_block.c.id, _block.c.first_us, _block.c.last_us, _block.c.samples)
                .where(
                    *window.overlap_conditions(),
                    or_(
                        _block.c.first_us > after[0],
                        and_(_block.c.first_us == after[0], _block.c.id > after[1]),
                    ),
                )
                .order_by(_block.c.first_us, _block.c.id)
                .limit(AT_ONCE + 1)
            )
            with engine.begin() as connection:
                rows = connection.execute(query).all()
                more = len(rows) > AT_ONCE
                past_us = rows[AT_ONCE].first_us if more else FARTHEST_US + 1
                until_us = min([past_us, *(int(held.time_us[0]) for held in waiting.values())])
                to_us = min(window.to_us, until_us - 1)
                ready = read_run(connection, rows[:AT_ONCE], window.from_us, to_us, last=shared)
                read = {}
                if ready is None:
                    read = read_blocks(connection, [row.id for row in rows[:AT_ONCE]])
            if more:
                after = (rows[AT_ONCE - 1].first_us, rows[AT_ONCE - 1].id)
            if ready is not None and more and until_us == past_us:
                yield SampleChunk(ready, max(past_us, window.from_us))
                continue
            if ready is not None:
                waiting[rows[0].id] = ready
            for number, samples in read.items():
                waiting[number] = samples.between_times(window.from_us, window.to_us)
            ready, waiting = _split_waiting(waiting, past_us)
            yield SampleChunk(ready, max(past_us, window.from_us))

    return pieces()


def _split_waiting(
    waiting: dict[int, BlockSamples], past_us: int
) -> tuple[BlockSamples, dict[int, BlockSamples]]:
    """Take what lies before a time, in order of time, and what is left of each block."""
    before, left = [], {}
    for number in sorted(waiting):
        samples = waiting[number]
        before.append(samples.between_times(-(2**63), past_us - 1))
        rest = samples.between_times(past_us, 2**63 - 1)
        if rest.time_us.size:
            left[number] = rest
    return (in_order(concatenate_samples(before)) if before else EMPTY), left
