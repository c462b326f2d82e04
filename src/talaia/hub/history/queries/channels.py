"""Which channels have history, and from when to when."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import func, select

from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Collection

    from sqlalchemy import Engine

    from talaia.hub.history.writing.block_index import BlockIndex

__all__ = ["StoredChannel", "stored_channels"]


class StoredChannel(NamedTuple):
    """A channel that has history; a renamed one is there under both its names.

    Attributes:
        samples: how many are kept.
        first_us: the earliest one's time (µs since the epoch).
        last_us: the latest one's time.

    """

    address: str
    samples: int
    first_us: int
    last_us: int


def stored_channels(
    engine: Engine, ledger: BlockIndex, site: str, without: Collection[str] = ()
) -> list[StoredChannel]:
    """List a site's channels that have samples, by address; those in ``without`` are not read."""
    left_out = frozenset(without)
    names, tails = ledger.names, ledger.tails
    # Memory before the database, as for every reading.
    before = tails.block
    wanted = {
        address: channel
        for (owner, address), channel in sorted(names.channels.copy().items())
        if owner == site and address not in left_out
    }
    snapshots = tails.channel_snapshots(wanted.values())
    held = {address: (channel, snapshots[channel]) for address, channel in wanted.items()}
    block = tables.block
    query = (
        select(
            block.c.channel_id,
            func.sum(block.c.samples),
            func.min(block.c.first_us),
            func.max(block.c.last_us),
        )
        .where(block.c.channel_id.in_([channel for channel, _ in held.values()]))
        .where(block.c.id < before)
        .group_by(block.c.channel_id)
    )
    with engine.begin() as connection:
        sealed = {row[0]: tuple(row)[1:] for row in connection.execute(query)}
    found = []
    for address, (channel, (samples, _)) in held.items():
        count, first, last = sealed.get(channel, (0, None, None))
        times = [time for time in (first, last) if time is not None]
        if samples.time_us.size:
            times += [int(samples.time_us.min()), int(samples.time_us.max())]
        if times:
            total = int(count) + int(samples.time_us.size)
            found.append(StoredChannel(address, total, min(times), max(times)))
    return found
