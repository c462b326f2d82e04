"""Measures new pictures of the archive, one after the other, in a process that may be ended."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import signal
import sys
from typing import TYPE_CHECKING

import msgspec

from talaia.hub.archive.measure_child import MeasuredFile
from talaia.hub.errors import StoreDown

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.hub.archive.frame_queues import FrameQueues
    from talaia.hub.archive.frame_rows import ArchivedFrame

__all__ = ["FrameMeasurer"]

log = logging.getLogger(__name__)
# A picture that takes longer is left as it came (s of a processor).
_MOST_S = 60.0
# The same by the clock: what measures gives way to all others on the machine, and waits for them.
_LONGEST_S = 1800.0
# The process ends when there was nothing to do for so long (s).
_IDLE_S = 30.0
# Pictures often come in threes; a process is not begun for each (s).
_GATHER_S = 1.0
# Until the database is asked again after it did not answer (s).
_RETRY_S = 5.0
# What a process needs of our surroundings; secrets of the hub's are not among it.
_SURROUNDINGS = ("PATH", "PYTHONPATH", "LANG", "HOME")


class FrameMeasurer:
    """See the module. What waits is in the database, so that it outlives the hub."""

    def __init__(self, queues: FrameQueues, most_s: float = _MOST_S) -> None:
        """Measure what waits in ``queues``; ``most_s``: of a processor, for each picture."""
        self._queues, self._most_s = queues, most_s
        self._child: asyncio.subprocess.Process | None = None

    async def run(self) -> None:
        """Measure what comes, until cancelled."""
        try:
            while True:
                try:
                    await self._measure_all()
                except StoreDown:
                    await asyncio.sleep(_RETRY_S)
                    continue
                await self._wait_for_more()
        finally:
            await self._end_child()

    async def _measure_all(self) -> None:
        while (frame := await self._queues.next_unmeasured()) is not None:
            try:
                async with self._queues.frame_copy(frame) as path:
                    measured = await self._measure_file(path)
                    made = path.with_suffix(".measured") if measured.made else None
                    await self._keep_measures(frame, measured, made)
            except FileNotFoundError:
                await self._keep_measures(frame, MeasuredFile(note="its file is not there"))

    async def _keep_measures(
        self, frame: ArchivedFrame, measured: MeasuredFile, made: Path | None = None
    ) -> None:
        if measured.note:
            log.info("%s: %s", frame.name, measured.note)
        await self._queues.keep_measures(frame, measured, made)

    async def _wait_for_more(self) -> None:
        news = self._queues.arrived
        try:
            async with asyncio.timeout(_IDLE_S if self._child is not None else None):
                await news.wait()
        except TimeoutError:
            await self._end_child()
            return
        news.clear()
        await asyncio.sleep(_GATHER_S)

    async def _measure_file(self, path: Path) -> MeasuredFile:
        try:
            async with asyncio.timeout(_LONGEST_S):
                return await self._ask_child(path)
        except TimeoutError:
            await self._end_child()
            return MeasuredFile(note=f"it could not be measured within {_LONGEST_S:g} s")
        except (OSError, ValueError, msgspec.DecodeError) as error:
            await self._end_child()
            return MeasuredFile(note=f"what measures pictures has ended: {error}"[:300])
        except asyncio.CancelledError:
            # Half an answer would be taken for the next picture's.
            await self._end_child()
            raise

    async def _ask_child(self, path: Path) -> MeasuredFile:
        if self._child is None or self._child.returncode is not None:
            kept = {name: os.environ[name] for name in _SURROUNDINGS if name in os.environ}
            self._child = await asyncio.create_subprocess_exec(
                sys.executable,
                "-m",
                "talaia.hub.archive.measure_child",
                f"{self._most_s:g}",
                stdin=asyncio.subprocess.PIPE,
                stdout=asyncio.subprocess.PIPE,
                stderr=asyncio.subprocess.DEVNULL,
                # One thread of numpy: the other cores are not this task's.
                env={**kept, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
            )
        child = self._child
        if child.stdin is None or child.stdout is None:
            raise OSError("it has no pipes")
        child.stdin.write(msgspec.json.encode(str(path)) + b"\n")
        await child.stdin.drain()
        line = await child.stdout.readline()
        if not line:
            ended = await child.wait()
            if ended == -signal.SIGPROF:
                words = f"it could not be measured within {self._most_s:g} s of a processor"
                return MeasuredFile(note=words)
            raise OSError("it gave no answer")
        return msgspec.json.decode(line, type=MeasuredFile)

    async def _end_child(self) -> None:
        child, self._child = self._child, None
        if child is not None and child.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                child.kill()
            await child.wait()
