"""Which channels' samples the next commit makes blocks of, and which it only saves."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Collection

    from talaia.hub.history.blocks.journal_rows import JournalRows
    from talaia.hub.history.limits import HistoryLimits
    from talaia.hub.history.writing.open_blocks import Tails

__all__ = ["SealChoice", "sealing_size"]

# Channels of a site that moves, made blocks in one commit.
_MOST_SEALED = 256


class SealChoice:
    """Chooses after each commit, a few at a time; for the writing thread only.

    Attributes:
        samples, rows: came since the last choice: the next one takes twice as many, so it does not
            fall behind.

    """

    def __init__(self, limits: HistoryLimits) -> None:
        """Choose by these sizes."""
        self._limits = limits
        # Channels with a block's worth, the fullest last, as they were when batches were dealt out.
        self._full: list[int] = []
        # Of which tails that is known, and after how many deals.
        self._full_as_of: tuple[Tails | None, int] = (None, 0)
        # Channels that are made blocks however few samples they have.
        self._wanted: set[int] = set()
        # Those whose samples are nowhere but in the journal, the one that keeps the oldest row
        # last; sought again when all of them were chosen, for there may be ten thousand.
        self._keeping: list[int] = []
        self.samples = self.rows = 0

    def seal_soon(self, channels: Collection[int]) -> None:
        """Let these be chosen next, however few samples they have; once."""
        self._wanted |= set(channels)

    def choose_channels(
        self, tails: Tails, journal: JournalRows
    ) -> tuple[list[int], list[int], int]:
        """Give the channels to seal, those to save, and a block's size."""
        if self._wanted or tails.is_due():
            tails.deal_chunks()
        enough = sealing_size(self._limits, len(tails.all_tails()))
        if self._full_as_of != (tails, tails.deals):
            self._full_as_of = (tails, tails.deals)
            # The fullest last: of channels that run in step, none falls behind for good.
            sizes = [(tail.size, channel) for channel, tail in tails.all_tails().items()]
            self._full = [channel for size, channel in sorted(sizes) if size >= enough]
        channels = len(tails.all_tails())
        has_many = journal.samples > self._limits.journal + 2 * enough * channels
        has_many_rows = len(journal) > self._limits.journal_rows
        # Twice as many as come, so that they are never more than a few behind.
        budget = 1 + self.samples // (enough // 2)
        if has_many_rows:
            # While so many rows come as there may be, each channel has its turn, and a few again.
            budget += round(1.1 * self.rows * channels / self._limits.journal_rows)
        self.samples = self.rows = 0
        chosen = self._fullest(tails, budget)
        if self._wanted:
            chosen += self._choose_wanted(tails, chosen)
        saved: list[int] = []
        if has_many or has_many_rows:
            for channel in self._oldest(tails, budget - len(chosen), {*chosen}):
                full_enough = tails.all_tails()[channel].size >= self._limits.block // 2
                (chosen if full_enough else saved).append(channel)
        return chosen, saved, enough

    def _fullest(self, tails: Tails, count: int) -> list[int]:
        """Take the channels that have a block's worth, ``count`` at the most."""
        found: list[int] = []
        while self._full and len(found) < count:
            channel = self._full.pop()
            # Some may have been made blocks because of the journal.
            if channel in tails.all_tails():
                found.append(channel)
        return found

    def _oldest(self, tails: Tails, count: int, but: set[int]) -> list[int]:
        """Take the channels that keep the oldest rows of the journal, ``count`` at the most."""
        held = tails.all_tails()
        found: list[int] = []
        sought = False
        while len(found) < count:
            if not self._keeping:
                if sought:
                    break
                rows = [
                    (tail.oldest_row, channel)
                    for channel, tail in held.items()
                    if tail.oldest_row is not None
                ]
                self._keeping = [channel for _, channel in sorted(rows, reverse=True)]
                sought = True
                continue
            channel = self._keeping.pop()
            # Some of them were made blocks meanwhile.
            if channel in held and held[channel].oldest_row is not None and channel not in but:
                found.append(channel)
                but.add(channel)
        return found

    def _choose_wanted(self, tails: Tails, chosen: list[int]) -> list[int]:
        open_ones = self._wanted & (tails.all_tails().keys() - set(chosen))
        # The rest is asked for again.
        self._wanted.clear()
        found = sorted(open_ones)[:_MOST_SEALED]
        self._full = [channel for channel in self._full if channel not in open_ones]
        return found


def sealing_size(limits: HistoryLimits, channels: int) -> int:
    """Give how many samples a channel may hold in memory before they are made blocks."""
    channels = max(1, channels)
    most = max(limits.block, min(limits.largest, limits.held // channels))
    # Ten thousand channels of a few thousand samples each would take most of a gigabyte.
    return min(most, max(min(limits.block, limits.smallest), limits.most_held // channels))
