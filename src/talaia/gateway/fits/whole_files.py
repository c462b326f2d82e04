"""Takes FITS files that come whole, in one message, onto the disk and into the outbox: each once.

A latched topic gives its newest file again after every reconnect and restart. So the digests of
the newest files of each camera are remembered on disk; and as nothing of the moment is written
into a header, the hub knows a file again that came twice all the same.
"""

from __future__ import annotations

import hashlib
import logging
import shutil
import threading
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.gateway.errors import FieldError
from talaia.gateway.fits.header import (
    BLOCK,
    HeaderCard,
    NotFits,
    length_of,
    rewrite_header,
    values_of,
)
from talaia.gateway.persistence import write_whole

if TYPE_CHECKING:
    from collections.abc import Callable
    from concurrent.futures import Executor
    from pathlib import Path

    from talaia.clock import Clock
    from talaia.gateway.fits.outbox import ArchiveOutbox
    from talaia.gateway.ports import EventSink
    from talaia.model.interlocks.enclosure import Place

__all__ = ["MOST_WAITING", "WholeFiles", "complete_header"]

log = logging.getLogger(__name__)
# So many files may wait in memory for a slow disk.
MOST_WAITING = 4
# Of each camera so many files are known again; a topic repeats what its publisher keeps.
_REMEMBERED = 16
# Beside what is being written, so much of the disk is left for the rest of the machine.
_SPARE_BYTES = 256 * 1024 * 1024


def complete_header(header: bytes, site: str, device: str, place: Place | None) -> bytes:
    """Give a picture's header with site and camera; what the camera wrote of the site stays.

    The same header gives the same bytes, whenever it is asked for.
    """
    cards = [
        HeaderCard("OBSERVAT", site, "observatory"),
        HeaderCard("INSTRUME", device, "camera"),
    ]
    known = values_of(header)
    # All of the place or nothing: half of the camera's and half of ours would be nowhere.
    if place is not None and not known.keys() & {"SITELAT", "SITELONG"}:
        cards += [
            HeaderCard("SITELAT", place.latitude, "[deg] latitude of the site"),
            HeaderCard("SITELONG", place.longitude, "[deg] longitude of the site, east positive"),
            HeaderCard("SITEELEV", place.elevation, "[m] height of the site"),
        ]
    ours = [
        HeaderCard("ORIGIN", "Talaia", "control room that kept this file"),
        HeaderCard("TALAIADV", device, "site and device of the camera"),
    ]
    return rewrite_header(header, [*ours, *(card for card in cards if card.key not in known)])


class _File(NamedTuple):
    """A file that waits for the disk: its camera, what reads it, and when it came (µs, UTC)."""

    device: str
    read: Callable[[], bytes]
    time_us: int


class WholeFiles:
    """A `FileSink`."""

    def __init__(
        self,
        *,
        folder: Path,
        outbox: ArchiveOutbox,
        events: EventSink,
        clock: Clock,
        disk: Executor,
        site: str,
        place: Place | None,
    ) -> None:
        """Work in ``folder`` on the thread of ``disk``; ``site`` and ``place`` go into headers."""
        self._folder, self._outbox = folder, outbox
        self._events, self._clock, self._disk = events, clock, disk
        self._site, self._place = site, place
        self._waiting = threading.Semaphore(MOST_WAITING)
        # On the disk's thread only: digests by device, oldest first, and what was last wrong.
        self._seen: dict[str, list[str]] | None = None
        self._problems: dict[str, str] = {}

    def keep_file(self, device: str, read: Callable[[], bytes]) -> None:
        """See `FileSink.keep_file`."""
        if not self._waiting.acquire(blocking=False):
            problem = "the gateway's disk is too slow for it"
            log.warning("%s: a picture is not kept: %s", device, problem)
            self._events.report_event("picture_lost", problem, device=device)
            return
        file = _File(device, read, self._clock.wall_ns() // 1000)
        try:
            self._disk.submit(self._keep_file, file)
        except RuntimeError:
            # The gateway ends. A latched file comes again.
            self._waiting.release()

    # ── on the disk's thread ──

    def _keep_file(self, file: _File) -> None:
        try:
            self._keep(file)
            self._problems.pop(file.device, None)
        except (OSError, NotFits, FieldError, ValueError, RuntimeError) as error:
            # The last two: a message that is not of its type.
            problem = str(error)
            # Said once: a topic of something else may be a fast one.
            if self._problems.get(file.device) != problem:
                self._problems[file.device] = problem
                log.warning("%s: a picture is not kept: %s", file.device, problem)
                self._events.report_event("picture_lost", problem, device=file.device)
        finally:
            self._waiting.release()

    def _keep(self, file: _File) -> None:
        data = file.read()
        digest = hashlib.sha256(data).hexdigest()
        known = self._known_digests().setdefault(file.device, [])
        if digest in known:
            return
        length = length_of(data[: 1024 * BLOCK])
        if length is None or length > len(data):
            raise NotFits("the picture is not FITS: it ends in its header")
        header = complete_header(data[:length], self._site, file.device, self._place)
        self._folder.mkdir(parents=True, exist_ok=True)
        if shutil.disk_usage(self._folder).free < len(data) + _SPARE_BYTES:
            raise OSError("the gateway's disk is full")
        made = self._folder / "whole.part"
        try:
            with made.open("wb") as written:
                written.write(header)
                written.write(memoryview(data)[length:])
                # Whole blocks, as the standard has it.
                written.write(bytes(-written.tell() % BLOCK))
            self._outbox.add_file(made, "fits", file.device, file.time_us)
        finally:
            made.unlink(missing_ok=True)
        known.append(digest)
        del known[:-_REMEMBERED]
        write_whole(self._path, msgspec.json.encode(self._seen))

    @property
    def _path(self) -> Path:
        return self._folder / "seen.json"

    def _known_digests(self) -> dict[str, list[str]]:
        if self._seen is None:
            try:
                self._seen = msgspec.json.decode(self._path.read_bytes(), type=dict[str, list[str]])
            except FileNotFoundError:
                self._seen = {}
            except (OSError, msgspec.DecodeError) as error:
                # Nothing is lost by it: the hub knows a file again.
                log.warning("%s cannot be read and begins anew: %s", self._path, error)
                self._seen = {}
        return self._seen
