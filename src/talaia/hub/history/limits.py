"""How much the history holds back, writes at once and reads itself."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["HistoryLimits"]


class HistoryLimits(NamedTuple):
    """Sizes in samples, unless said otherwise.

    Attributes:
        block: a block's size while there are many channels; a channel with so many in memory is
            sealed.
        largest: a block's size while there are few. Larger blocks cost less for each sample, in
            time and in room, but wait in memory and in the journal until they are full.
        smallest: a block's size with thousands of channels; never more than ``block``.
        held: blocks are as large as they can be if all channels together hold no more than this.
        most_held: blocks are smaller than ``block`` if all channels together would hold more.
        recent: committed batches are dealt out to the channels when they hold so many; a reader
            has to look through them.
        journal: what the journal may hold beside two blocks of each channel, before slow
            channels' tails are saved to free it. It is what is read again after a crash.
        journal_rows: how many rows it may have before the same is done. Many gateways that send a
            sample each leave a row for each, and nobody is let in until all are read again.
        delete: journal rows deleted in one commit, beside four for each row written.
        raw: up to so many, decompressing is as quick as reading rollups, and more exact.
        linger_s: a commit of few samples begins so long after the last one (s), so that many
            small batches share one wait for the disk.
        show_s: a reading of each channel is written as a plain row this often (s); 0 is never.
        tidy_s: what is too old or too much is looked for this often (s); 0 is never.
        bytes: blocks may take so many bytes; then the oldest go. 0 sets no limit.
        cached: of blocks that were read, so many samples are held (16 bytes each).
        counted: of windows with more samples, outliers are sought in an even part of them.
        texts: of more texts than this the newest are shown, for they have no rollups.

    """

    block: int = 4_096
    largest: int = 16_384
    smallest: int = 1_024
    held: int = 1_048_576
    most_held: int = 8_388_608
    recent: int = 4_096
    journal: int = 500_000
    journal_rows: int = 131_072
    delete: int = 256
    raw: int = 250_000
    cached: int = 1_000_000
    counted: int = 100_000_000
    texts: int = 500_000
    linger_s: float = 0.05
    show_s: float = 2.0
    tidy_s: float = 600.0
    bytes: int = 0
