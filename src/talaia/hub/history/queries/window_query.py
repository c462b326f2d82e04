"""What is asked for: a channel's window, and what of it stands in memory just then."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.history.queries.window import FARTHEST_US, StoredWindow

if TYPE_CHECKING:
    from talaia.hub.history.blocks.block import BlockSamples
    from talaia.hub.history.writing.block_index import BlockIndex

__all__ = ["window_of"]


def window_of(
    ledger: BlockIndex, *, site: str, address: str, from_us: int, to_us: int
) -> tuple[StoredWindow, BlockSamples] | None:
    """Find a channel's window and what of the channel stands in memory; None if it has none.

    It comes before the database is asked: what is sealed after this look is still in the
    snapshot, and its blocks stay out of the window. The other way round, samples could be in
    neither.
    """
    run, names, tails = ledger.run, ledger.names, ledger.tails
    channel = names.channels.get((site, address))
    # A driver would take numpy's whole numbers for something else.
    from_us = max(-FARTHEST_US, min(FARTHEST_US, int(from_us)))
    to_us = max(-FARTHEST_US, min(FARTHEST_US, int(to_us)))
    if channel is None or from_us > to_us:
        return None
    samples, before = tails.channel_snapshot(channel, from_us, to_us)
    window = StoredWindow(channel, from_us, to_us, names.longest_us[channel], before, run)
    return window, samples
