"""Takes pictures from an adapter onto the disk, with whole headers, and into the outbox.

All disk work is on a thread of its own: a slow disk is not to hold a STOP.
"""

from __future__ import annotations

import asyncio
import logging
import shutil
import zlib
from typing import TYPE_CHECKING, BinaryIO, TypeVar

from talaia.gateway.fits.header import BLOCK, NotFits, length_of

if TYPE_CHECKING:
    from collections.abc import Callable
    from concurrent.futures import Executor
    from pathlib import Path

    from talaia.clock import Clock
    from talaia.gateway.fits.outbox import ArchiveOutbox
    from talaia.gateway.ports import EventSink

__all__ = ["FitsFrameWriter"]

T = TypeVar("T")
log = logging.getLogger(__name__)
_FORMATS = (".fits", ".fits.z", ".fits.fz", ".fit", ".fts")
# Beside what is being written, so much of the disk is left for the rest of the machine.
_SPARE_BYTES = 256 * 1024 * 1024


class FitsFrameWriter:
    """A `FrameSink`."""

    def __init__(
        self,
        *,
        folder: Path,
        outbox: ArchiveOutbox,
        events: EventSink,
        clock: Clock,
        disk: Executor,
    ) -> None:
        """Keep half a picture in ``folder``, and whole ones in the ``outbox``."""
        # Half a picture lies in the folder; whole ones go into the outbox.
        self._folder, self._outbox = folder, outbox
        self._events, self._clock, self._disk = events, clock, disk
        self._device = ""  # Whose picture is being taken.
        # Why it cannot be kept; "" so far. The rest of it is received and thrown away.
        self._problem = ""
        self._file: BinaryIO | None = None  # Open while a picture comes; used on the disk's thread.
        # Of a zlib-compressed BLOB (INDI's ".z"); None for plain ones.
        self._inflate: zlib._Decompress | None = None
        # Bytes so far, and as many as its driver said that there are.
        self._size, self._most = 0, 0
        # Puts into the header what the driver left out.
        self._complete: Callable[[bytes], bytes] = bytes
        self._began_us = 0  # When it began to come (µs UTC).

    async def begin(
        self, device: str, form: str, size: int, complete: Callable[[bytes], bytes]
    ) -> None:
        """See `FrameSink.begin`."""
        # A picture that was cut off by a lost connection.
        await self.drop()
        self._device, self._size, self._most = device, 0, size
        self._began_us = self._clock.wall_ns() // 1000
        self._complete = complete
        self._problem = ""
        word = form.lower()
        if not word.startswith(_FORMATS):
            self._problem = f"its format is {form or 'not said'}, and only FITS is kept"
            return
        self._inflate = zlib.decompressobj() if word.endswith(".z") else None
        await self._on_disk(self._open_file)

    async def write(self, data: bytes) -> None:
        """See `FrameSink.write`."""
        if not self._problem:
            await self._on_disk(lambda: self._write_bytes(data))

    async def end(self, problem: str) -> str:
        """See `FrameSink.end`."""
        self._problem = self._problem or problem
        if not self._problem:
            header = await self._on_disk(self._read_header)
            if header is not None:
                whole = self._complete(header)
                await self._on_disk(lambda: self._keep_frame(header, whole))
        if self._problem:
            log.warning("%s: a picture is not kept: %s", self._device, self._problem)
            self._events.report_event("picture_lost", self._problem, device=self._device)
        await self.drop()
        return self._problem

    async def drop(self) -> None:
        """See `FrameSink.drop`."""
        if self._file is not None:
            await self._on_disk(self._close_file)

    async def _on_disk(self, work: Callable[[], T]) -> T | None:
        """Do disk work; what fails there is the picture's problem, not the connection's."""
        try:
            return await asyncio.get_running_loop().run_in_executor(self._disk, work)
        except (OSError, NotFits, zlib.error) as error:
            self._problem = self._problem or str(error)
            return None

    # ── on the disk's thread ──

    @property
    def _path(self) -> Path:
        return self._folder / "taking.part"

    def _open_file(self) -> None:
        self._folder.mkdir(parents=True, exist_ok=True)
        # Twice: it is written once as it comes and once with its whole header.
        if shutil.disk_usage(self._folder).free < 2 * self._most + _SPARE_BYTES:
            raise OSError("the gateway's disk is full")
        self._file = self._path.open("w+b")

    def _write_bytes(self, data: bytes) -> None:
        if self._file is None:
            return
        if self._inflate is not None:
            # Bounded by what the driver said: a small file that grows for ever is refused.
            most = self._most - self._size + BLOCK
            data = self._inflate.decompress(data, max(1, most))
            if self._inflate.unconsumed_tail:
                raise OSError("it is larger than its driver said")
        self._size += len(data)
        self._file.write(data)

    def _read_header(self) -> bytes | None:
        if self._file is None:
            return None
        if self._inflate is not None:
            self._file.write(self._inflate.flush())
        self._file.seek(0)
        data = b""
        while (length := length_of(data)) is None:
            more = self._file.read(20 * BLOCK)
            if not more:
                raise NotFits("the picture is not FITS: it ends in its header")
            data += more
        return data[:length]

    def _keep_frame(self, header: bytes, whole: bytes) -> None:
        """Write it anew with the whole header, and into the outbox."""
        if self._file is None:
            return
        made = self._folder / "made.part"
        with made.open("wb") as file:
            file.write(whole)
            self._file.seek(len(header))
            shutil.copyfileobj(self._file, file, 1024 * 1024)
            # Whole blocks, as the standard has it; some drivers leave the last one short.
            file.write(bytes(-file.tell() % BLOCK))
        self._outbox.add_file(made, "fits", self._device, self._began_us)

    def _close_file(self) -> None:
        if self._file is not None:
            self._file.close()
            self._file = None
        self._path.unlink(missing_ok=True)
