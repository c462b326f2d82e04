"""All samples of a channel, in order of time, a piece at a time.

A database transaction lasts for one piece only: one that stays open while a slow reader takes an
hour over a download would keep SQLite's journal from being emptied. Blocks never change, and
memory is looked at once before the first of them, so the pieces fit each other all the same.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from talaia.hub.history.blocks.block import (
    EMPTY,
    BlockSamples,
    LastTimes,
    concatenate_samples,
    in_order,
)
from talaia.hub.history.queries.block_run import read_run
from talaia.hub.history.queries.window import FARTHEST_US, blocks_behind, read_blocks
from talaia.hub.history.queries.window_query import window_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from sqlalchemy import Engine

    from talaia.hub.history.writing.block_index import BlockIndex

__all__ = ["SampleChunk", "stream_samples"]

# Blocks of a piece: what is held at once is a few times as much.
AT_ONCE = 16
# Blocks whose places are asked for together.
_LISTED = 256
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
        # Blocks that are not read yet; whether there are more, behind the last of those listed.
        ahead: list[Any] = []
        after, more = (-(2**63), 0), True
        while more or ahead:
            with engine.begin() as connection:
                if more and len(ahead) <= AT_ONCE:
                    found = blocks_behind(connection, window, after, _LISTED)
                    ahead += found
                    more = len(found) == _LISTED
                    after = (found[-1].first_us, found[-1].id) if more else after
                rows, ahead = ahead[:AT_ONCE], ahead[AT_ONCE:]
                past_us = ahead[0].first_us if ahead else FARTHEST_US + 1
                until_us = min([past_us, *(int(held.time_us[0]) for held in waiting.values())])
                to_us = min(window.to_us, until_us - 1)
                ready = read_run(connection, rows, window.from_us, to_us, last=shared)
                read = {}
                if ready is None:
                    read = read_blocks(connection, [row.id for row in rows])
            if ready is not None:
                yield SampleChunk(ready, max(until_us, window.from_us))
                if ahead and until_us == past_us:
                    continue
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
