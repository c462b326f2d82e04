"""Asks the process that reads FITS files, a turn for each site, and ends it when it takes too long.

The process is begun when the first file is asked for, for astropy takes half a second and 60 MB,
and ends when nothing was asked for a while.
"""

from __future__ import annotations

import asyncio
import time
import weakref
from collections import defaultdict
from typing import TYPE_CHECKING

import msgspec

from talaia.hub.archive.child_pipes import ChildPipes
from talaia.hub.archive.fits_child import FitsAnswer, FitsQuestion
from talaia.hub.archive.fits_reader import NotKept, TooMuchToRead

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.hub.archive.fits_reader import Facts, Looks

__all__ = ["FitsProcess"]

# A file that takes longer is left unread (s).
_LONGEST_S = 60.0
# So long nothing was asked, and the process ends (s).
_IDLE_S = 120.0
# A preview is a picture of 1024 × 1024 at the most, and a header is cut.
_MOST_ANSWER = 16 * 1024 * 1024


class FitsProcess:
    """See the module. What it is asked may be asked from one event loop."""

    def __init__(self, longest_s: float = _LONGEST_S) -> None:
        """Give each file ``longest_s``."""
        self._longest_s = longest_s
        # One that asks at a time for each site, and one of these: sites take turns.
        self._turns: defaultdict[str, asyncio.Lock] = defaultdict(asyncio.Lock)
        self._turn = asyncio.Lock()
        self._pipes = ChildPipes("talaia.hub.archive.fits_child", most_answer=_MOST_ANSWER)
        # A hub that is gone leaves no process behind.
        weakref.finalize(self, self._pipes.end_process)
        self._idle: asyncio.TimerHandle | None = None

    async def read_facts(self, site: str, path: Path) -> Facts:
        """See `fits_reader.facts_of`.

        Raises:
            NotKept: it is no picture in FITS.
            TooMuchToRead: it takes more memory or time than may be had.

        """
        answer = await self._ask(site, FitsQuestion("facts", str(path)))
        if answer.facts is None:
            raise TooMuchToRead(_SILENT)
        return answer.facts

    async def read_looks(self, site: str, path: Path) -> Looks:
        """See `fits_reader.looks_of`, and `read_facts`."""
        answer = await self._ask(site, FitsQuestion("looks", str(path)))
        if answer.looks is None:
            raise TooMuchToRead(_SILENT)
        return answer.looks

    async def draw_preview(self, site: str, path: Path, stretch: str, most_px: int) -> bytes:
        """See `fits_reader.preview_of`, and `read_facts`."""
        return (await self._ask(site, FitsQuestion("preview", str(path), stretch, most_px))).preview

    async def _ask(self, site: str, asked: FitsQuestion) -> FitsAnswer:
        async with self._turns[site], self._turn:
            if self._idle is not None:
                self._idle.cancel()
            deadline = time.monotonic() + self._longest_s
            answer = await asyncio.to_thread(self._ask_process, asked, deadline)
            loop = asyncio.get_running_loop()
            self._idle = loop.call_later(_IDLE_S, self._pipes.end_process)
        if answer.unreadable:
            raise TooMuchToRead(answer.unreadable)
        if answer.refused:
            raise NotKept(answer.refused)
        return answer

    def _ask_process(self, asked: FitsQuestion, deadline: float) -> FitsAnswer:
        """Ask, and answer by itself where the process does not."""
        try:
            answer = self._pipes.ask([msgspec.msgpack.encode(asked)], deadline)
            return msgspec.msgpack.decode(answer, type=FitsAnswer)
        except TimeoutError:
            return FitsAnswer(unreadable="it takes longer than may be waited")
        except (OSError, ValueError, msgspec.MsgspecError):
            self._pipes.end_process()
            return FitsAnswer(unreadable="it ended what reads pictures")


_SILENT = "what reads pictures gave no answer"
