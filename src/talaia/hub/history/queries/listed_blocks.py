"""The blocks of many channels, looked up and read at once.

A question to the database costs more than its answer: 50 signals of a board, one by one, took
twice the processor time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from talaia.hub.history.queries.window import kept_bodies, overlapping_of_channels

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy import Connection

    from talaia.hub.history.blocks.block import BlockSamples
    from talaia.hub.history.blocks.cache import BlockCache
    from talaia.hub.history.queries.window import StoredWindow

__all__ = ["ListedBlocks", "list_together"]

# Blocks of all channels of a question that are listed together.
_MOST_LISTED = 800


class ListedBlocks(NamedTuple):
    """Where the blocks of several channels are, and what was read of them already.

    Attributes:
        rows: by channel, in order of time.
        bodies: by the block's number.

    """

    rows: dict[int, list[Any]]
    bodies: dict[int, BlockSamples]


def list_together(
    connection: Connection,
    windows: Sequence[StoredWindow],
    *,
    most: int,
    most_bodies: int,
    cache: BlockCache,
) -> ListedBlocks | None:
    """Look up the blocks of windows that are of the same time, and read them while they are few.

    Args:
        connection: to the database.
        windows: of different channels.
        most: a channel with more samples than this is not read: rollups will do.
        most_bodies: samples of all channels that are read at once.
        cache: holds blocks that were read.

    Returns:
        None where each channel is to be asked for by itself.

    """
    if len(windows) < 2 or len({window.run for window in windows}) > 1:
        return None
    rows = overlapping_of_channels(connection, windows, _MOST_LISTED)
    if rows is None:
        return None
    wanted = [
        row
        for channel in rows.values()
        # What a chart cannot draw is read as rollups.
        if sum(row.samples for row in channel) <= most
        for row in channel
    ]
    bodies: dict[int, BlockSamples] = {}
    # Beyond what the cache holds, memory would grow with the question.
    if sum(row.samples for row in wanted) <= most_bodies:
        bodies = kept_bodies(connection, [row.id for row in wanted], windows[0].run, cache)
    return ListedBlocks(rows, bodies)
