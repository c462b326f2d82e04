"""The newest sample of each of many channels, asked for all at once."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import select

from talaia.hub.history.blocks.block import EMPTY, in_order
from talaia.hub.history.queries.window import (
    FARTHEST_US,
    StoredWindow,
    kept_bodies,
    overlapping_of_channels,
)
from talaia.hub.history.queries.window_query import windows_of
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from sqlalchemy import Connection, Engine

    from talaia.hub.history.blocks.block import BlockSamples
    from talaia.hub.history.blocks.cache import BlockCache
    from talaia.hub.history.writing.block_index import BlockIndex

__all__ = ["read_newest"]

_block = tables.block
# Channels in one question.
_AT_ONCE = 500


class _Asked(NamedTuple):
    """A channel, and what of its window stands in memory, in order of time."""

    address: str
    window: StoredWindow
    tail: BlockSamples


def read_newest(
    engine: Engine,
    ledger: BlockIndex,
    cache: BlockCache | None,
    *,
    site: str,
    addresses: Sequence[str],
    to_us: int,
) -> dict[str, tuple[int, float, str]]:
    """Find time (µs), value and text of each channel's newest sample up to ``to_us``.

    A channel that has none is left out.
    """
    asked = list(_look_into_memory(ledger, site, addresses, to_us))
    found = {}
    with engine.begin() as connection:
        # What is in memory was looked at before, of all at one moment: blocks that were sealed
        # since are left out.
        for first in range(0, len(asked), _AT_ONCE):
            some = asked[first : first + _AT_ONCE]
            blocks = _newest_blocks(connection, cache, some)
            for one in some:
                last = _last_of([*blocks.get(one.window.channel, []), one.tail])
                if last is not None:
                    found[one.address] = last
    return found


def _last_of(parts: Sequence[BlockSamples]) -> tuple[int, float, str] | None:
    """Give the newest of samples that are in order; of equal times the one that came last."""
    newest: BlockSamples | None = None
    for part in parts:
        if part.time_us.size and (newest is None or part.time_us[-1] >= newest.time_us[-1]):
            newest = part
    if newest is None:
        return None
    at = newest.time_us.size - 1
    return int(newest.time_us[at]), float(newest.value[at]), newest.texts.get(at, "")


def _look_into_memory(
    ledger: BlockIndex, site: str, addresses: Sequence[str], to_us: int
) -> Iterator[_Asked]:
    found = windows_of(ledger, site=site, addresses=addresses, from_us=-FARTHEST_US, to_us=to_us)
    for address, known in zip(addresses, found, strict=True):
        if known is not None:
            window, held = known
            tail = in_order(held).between_times(window.from_us, window.to_us)
            yield _Asked(address, window, tail)


def _newest_blocks(
    connection: Connection, cache: BlockCache | None, asked: Sequence[_Asked]
) -> dict[int, list[BlockSamples]]:
    """Read what may hold the newest sample of each window, unless its tail's newest is newer.

    The windows end together and leave out the same blocks.
    """
    window = asked[0].window
    # All of the block that ends last is in the window, and the newest is its last sample ...
    wanted = _last_whole(connection, [one.window.channel for one in asked], window)
    # ... or it is in a block that goes on beyond the window's end.
    reach = [one.window._replace(from_us=window.to_us) for one in asked]
    cut = None if window.to_us >= FARTHEST_US else overlapping_of_channels(connection, reach)
    for one in asked:
        ends = wanted.setdefault(one.window.channel, {})
        if cut is not None:
            ends.update({row.id: row.last_us for row in cut[one.window.channel]})
        if one.tail.time_us.size and all(end <= one.tail.time_us[-1] for end in ends.values()):
            ends.clear()
    every = sorted({number for numbers in wanted.values() for number in numbers})
    read = kept_bodies(connection, every, window.run, cache)
    return {
        # In the order of their numbers, which is that in which they came.
        channel: [
            in_order(read.get(number, EMPTY)).between_times(window.from_us, window.to_us)
            for number in sorted(numbers)
        ]
        for channel, numbers in wanted.items()
    }


def _last_whole(
    connection: Connection, channels: Sequence[int], window: StoredWindow
) -> dict[int, dict[int, int]]:
    """Give for each channel the block that ends last before the window does: number to end (µs)."""
    channel = tables.channel
    # The database goes to the end of its index for each channel, whatever lies before it.
    last = (
        select(_block.c.id)
        .where(_block.c.channel_id == channel.c.id, _block.c.id < window.before_block)
        .where(_block.c.last_us <= window.to_us)
        .order_by(_block.c.last_us.desc(), _block.c.id.desc())
        .limit(1)
    )
    number = last.scalar_subquery().correlate(channel)
    end = last.with_only_columns(_block.c.last_us).scalar_subquery().correlate(channel)
    query = select(channel.c.id, number.label("number"), end.label("last_us"))
    rows = connection.execute(query.where(channel.c.id.in_(channels)))
    return {row.id: {row.number: row.last_us} for row in rows if row.number is not None}
