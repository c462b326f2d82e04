"""Asks the process that reads FITS files, a turn for each site, and ends it when it takes too long.

The process is begun when the first file is asked for, for astropy takes half a second and 60 MB,
and ends when nothing was asked for a while.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import select
import subprocess
import sys
import threading
import time
import weakref
from collections import defaultdict
from typing import TYPE_CHECKING

import msgspec

from talaia.hub.archive.fits_child import LENGTH, FitsAnswer, FitsQuestion
from talaia.hub.archive.fits_reader import NotKept, TooMuchToRead

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.hub.archive.fits_reader import Facts, Looks

__all__ = ["FitsProcess"]

# A file that takes longer is left unread (s).
_LONGEST_S = 60.0
# So long nothing was asked, and the process ends (s).
_IDLE_S = 120.0
# What a process needs of our surroundings; secrets of the hub's are not among it.
_SURROUNDINGS = ("PATH", "PYTHONPATH", "LANG", "HOME")
_PLAIN = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1"}
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
        self._pipes = _FitsPipes()
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
            answer = await asyncio.to_thread(self._pipes.ask, asked, deadline)
            loop = asyncio.get_running_loop()
            self._idle = loop.call_later(_IDLE_S, self._pipes.end_process)
        if answer.unreadable:
            raise TooMuchToRead(answer.unreadable)
        if answer.refused:
            raise NotKept(answer.refused)
        return answer


_SILENT = "what reads pictures gave no answer"


class _FitsPipes:
    """The process and its pipes; used from threads, one at a time."""

    def __init__(self) -> None:
        # Held while a file is read, by a thread that nobody may wait for any more.
        self._busy = threading.Lock()
        self._child: subprocess.Popen[bytes] | None = None

    def ask(self, asked: FitsQuestion, deadline: float) -> FitsAnswer:
        """Ask, and answer by itself where the process does not."""
        with self._busy:
            try:
                return self._exchange(asked, deadline)
            except TimeoutError:
                self.end_process()
                return FitsAnswer(unreadable="it takes longer than may be waited")
            except (OSError, ValueError, msgspec.MsgspecError):
                self.end_process()
                return FitsAnswer(unreadable="it ended what reads pictures")

    def end_process(self) -> None:
        """End it, if there is one."""
        child, self._child = self._child, None
        if child is None:
            return
        child.kill()
        child.wait()
        for pipe in (child.stdin, child.stdout):
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()

    def _exchange(self, asked: FitsQuestion, deadline: float) -> FitsAnswer:
        child = self._child
        if child is None or child.poll() is not None:
            self.end_process()
            child = self._child = subprocess.Popen(
                [sys.executable, "-m", "talaia.hub.archive.fits_child"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env={
                    **{name: os.environ[name] for name in _SURROUNDINGS if name in os.environ},
                    **_PLAIN,
                },
            )
        if child.stdin is None or child.stdout is None:
            raise OSError("it has no pipes")
        body = msgspec.msgpack.encode(asked)
        child.stdin.write(LENGTH.pack(len(body)) + body)
        child.stdin.flush()
        out = child.stdout.fileno()
        (size,) = LENGTH.unpack(_read_whole(out, LENGTH.size, deadline))
        if size > _MOST_ANSWER:
            raise ValueError(f"an answer of {size} bytes")
        return msgspec.msgpack.decode(_read_whole(out, size, deadline), type=FitsAnswer)


def _read_whole(number: int, size: int, deadline: float) -> bytes:
    """Read so many bytes of a pipe, unless they do not come in time."""
    poll = select.poll()
    poll.register(number, select.POLLIN)
    parts = bytearray()
    while len(parts) < size:
        if not poll.poll(max(0.0, deadline - time.monotonic()) * 1000):
            raise TimeoutError
        part = os.read(number, size - len(parts))
        if not part:
            raise OSError("it has ended")
        parts += part
    return bytes(parts)
