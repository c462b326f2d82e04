"""The newest sample of each of many channels, asked for all at once."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import select

from talaia.hub.history.queries.window import (
    FARTHEST_US,
    StoredWindow,
    kept_bodies,
    overlapping_of_channels,
)
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from sqlalchemy import ColumnElement, Connection, Engine, ScalarSelect, Select

    from talaia.hub.history.blocks.block import Reading
    from talaia.hub.history.blocks.cache import BlockCache
    from talaia.hub.history.writing.block_index import BlockIndex
    from talaia.hub.history.writing.channel_ids import Names

__all__ = ["read_newest"]

_block = tables.block
_channel = tables.channel
# Channels in one question.
_AT_ONCE = 500


class _Moment(NamedTuple):
    """Up to when, and what was in memory as it was looked at; ``run``: see `StoredWindow`."""

    to_us: int
    held: Mapping[int, Reading]
    before_block: int
    run: int


def read_newest(
    engine: Engine,
    ledger: BlockIndex,
    cache: BlockCache | None,
    *,
    site: str,
    addresses: Sequence[str],
    to_us: int,
) -> dict[str, Reading]:
    """Find time (µs), value and text of each channel's newest sample up to ``to_us``.

    A channel that has none is left out.
    """
    # The memory comes before the database: see `windows_of`.
    run, names, tails = ledger.run, ledger.names, ledger.tails
    # A driver would take numpy's whole numbers for something else.
    to_us = min(FARTHEST_US, int(to_us))
    numbers = {address: names.channels.get((site, address)) for address in addresses}
    channels = sorted({number for number in numbers.values() if number is not None})
    if to_us < -FARTHEST_US or not channels:
        return {}
    held = tails.newest_readings(channels, to_us)
    moment = _Moment(to_us, held.readings, held.block, run)
    found = dict(held.readings)
    with engine.begin() as connection:
        for first in range(0, len(channels), _AT_ONCE):
            some = channels[first : first + _AT_ONCE]
            wanted = _blocks_to_read(connection, some, moment, names)
            found |= _read_blocks(connection, cache, wanted, moment)
    return {address: found[number] for address, number in numbers.items() if number in found}


def _blocks_to_read(
    connection: Connection, channels: Sequence[int], moment: _Moment, names: Names
) -> dict[int, list[int]]:
    """Give for each channel the blocks that may hold something newer than the memory does."""
    # All of the block that ends last is before the moment, and the newest is its last sample ...
    ends = _last_ends(connection, [one for one in channels if one in moment.held], moment)
    behind = [one for one in channels if _is_newer(ends.get(one), moment.held.get(one))]
    behind += [one for one in channels if one not in moment.held]
    wanted = {channel: [number] for channel, number in _last_whole(connection, behind, moment)}
    if moment.to_us >= FARTHEST_US:
        return wanted
    # ... or it is in a block that goes on beyond it.
    reach = [
        StoredWindow(
            channel,
            moment.to_us,
            moment.to_us,
            names.longest_us[channel],
            moment.before_block,
            moment.run,
        )
        for channel in channels
    ]
    for channel, rows in (overlapping_of_channels(connection, reach) or {}).items():
        wanted.setdefault(channel, []).extend(row.id for row in rows)
    return wanted


def _is_newer(end_us: int | None, held: Reading | None) -> bool:
    return end_us is not None and held is not None and end_us > held[0]


def _read_blocks(
    connection: Connection,
    cache: BlockCache | None,
    wanted: Mapping[int, Sequence[int]],
    moment: _Moment,
) -> dict[int, Reading]:
    """Give what blocks have that is newer than what is in memory."""
    every = sorted({number for numbers in wanted.values() for number in numbers})
    read = kept_bodies(connection, every, moment.run, cache)
    found: dict[int, Reading] = {}
    for channel, numbers in wanted.items():
        best: Reading | None = None
        # In the order of their numbers, which is that in which they came.
        for number in sorted(set(numbers)):
            early = read[number].up_to(moment.to_us) if number in read else None
            if early is not None and early.time_us.size:
                reading = early.newest_reading()
                best = reading if best is None or reading[0] >= best[0] else best
        held = moment.held.get(channel)
        # Of equal times, what is in memory came last.
        if best is not None and (held is None or best[0] > held[0]):
            found[channel] = best
    return found


def _last_ends(connection: Connection, channels: Sequence[int], moment: _Moment) -> dict[int, int]:
    """Give for each channel when the block ends that ends last before a moment (µs)."""
    if not channels:
        return {}
    rows = connection.execute(_of_channels(_last_block(_block.c.last_us, moment), channels))
    return {channel: last_us for channel, last_us in rows if last_us is not None}


def _last_whole(
    connection: Connection, channels: Sequence[int], moment: _Moment
) -> list[tuple[int, int]]:
    """Give for each channel that has any the block that ends last before a moment does."""
    if not channels:
        return []
    rows = connection.execute(_of_channels(_last_block(_block.c.id, moment), channels))
    return [(channel, number) for channel, number in rows if number is not None]


def _last_block(column: ColumnElement[int], moment: _Moment) -> ScalarSelect[int]:
    # The database goes to the end of its index for each channel, whatever lies before it.
    return (
        select(column)
        .where(_block.c.channel_id == _channel.c.id, _block.c.id < moment.before_block)
        .where(_block.c.last_us <= moment.to_us)
        .order_by(_block.c.last_us.desc(), _block.c.id.desc())
        .limit(1)
        .scalar_subquery()
        .correlate(_channel)
    )


def _of_channels(asked: ScalarSelect[int], channels: Sequence[int]) -> Select[int, int | None]:
    return select(_channel.c.id, asked).where(_channel.c.id.in_(channels))
