"""What is asked for: windows of channels, and what of them stands in memory just then."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.history.queries.window import FARTHEST_US, StoredWindow

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.hub.history.blocks.block import BlockSamples
    from talaia.hub.history.writing.block_index import BlockIndex

__all__ = ["window_of", "windows_of"]


def window_of(
    ledger: BlockIndex, *, site: str, address: str, from_us: int, to_us: int
) -> tuple[StoredWindow, BlockSamples] | None:
    """Find one channel's window; see `windows_of`."""
    (found,) = windows_of(ledger, site=site, addresses=[address], from_us=from_us, to_us=to_us)
    return found


def windows_of(
    ledger: BlockIndex, *, site: str, addresses: Sequence[str], from_us: int, to_us: int
) -> list[tuple[StoredWindow, BlockSamples] | None]:
    """Find each channel's window and what of the channel stands in memory; None if it has none.

    It comes before the database is asked: what is sealed after this look is still in the
    snapshot, and its blocks stay out of the window. The other way round, samples could be in
    neither.
    """
    run, names, tails = ledger.run, ledger.names, ledger.tails
    # A driver would take numpy's whole numbers for something else.
    from_us = max(-FARTHEST_US, min(FARTHEST_US, int(from_us)))
    to_us = max(-FARTHEST_US, min(FARTHEST_US, int(to_us)))
    if from_us > to_us:
        return [None] * len(addresses)
    channels = [names.channels.get((site, address)) for address in addresses]
    known = {channel for channel in channels if channel is not None}
    held = tails.channel_snapshots(known, from_us, to_us)
    found: list[tuple[StoredWindow, BlockSamples] | None] = []
    for channel in channels:
        if channel is None:
            found.append(None)
            continue
        samples, before = held[channel]
        longest_us = names.longest_us[channel]
        found.append((StoredWindow(channel, from_us, to_us, longest_us, before, run), samples))
    return found
