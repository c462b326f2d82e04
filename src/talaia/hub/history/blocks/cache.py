"""Blocks that were read lately, decompressed.

Who looks at the last ten minutes asks for nearly the same blocks every second, and so do all others
who look at them; decompressing is most of the work of such a read.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.hub.history.blocks.block import BlockSamples

__all__ = ["BlockCache"]


class BlockCache:
    """The blocks read last, up to a number of samples in all; from any thread.

    A block never changes, and its number is given once in a run, so what is here stays true. A
    ledger that loads anew may give a number again: then all is forgotten (see ``run``).
    """

    def __init__(self, most: int) -> None:
        """Hold up to ``most`` samples (16 bytes each)."""
        # Samples that are held at most; of the rest, what was read longest ago goes.
        self._most = most
        # Readers are several threads, and to look something up moves it to the end.
        self._lock = threading.Lock()
        # By number; what was asked for last stands last.
        self._held: OrderedDict[int, BlockSamples] = OrderedDict()
        # In all of them: to count them anew for each block would take longer than to read it.
        self._samples = 0
        # The load of the ledger that the numbers are of.
        self._run = 0

    @property
    def bytes(self) -> int:
        """Memory that the samples take: a time and a value each."""
        return 16 * self._samples

    def find_blocks(self, run: int, ids: Iterable[int]) -> dict[int, BlockSamples]:
        """Give those of the blocks that are here; ``run`` counts the ledger's loads."""
        with self._lock:
            self._begin_run(run)
            known = {number: self._held[number] for number in ids if number in self._held}
            for number in known:
                self._held.move_to_end(number)
            return known

    def add_blocks(self, run: int, read: dict[int, BlockSamples]) -> None:
        """Take in blocks that were read; what was not asked for longest goes."""
        with self._lock:
            if run != self._run:
                return
            for number, samples in read.items():
                # Of texts nobody knows how much memory they take.
                if number not in self._held and not samples.texts:
                    self._held[number] = samples
                    self._samples += samples.time_us.size
            while self._samples > self._most:
                _, gone = self._held.popitem(last=False)
                self._samples -= gone.time_us.size

    def _begin_run(self, run: int) -> None:
        if run > self._run:
            self._held.clear()
            self._samples, self._run = 0, run
