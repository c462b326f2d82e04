"""What driving keeps on disk over a restart: epochs of leases and STOP latches."""

from __future__ import annotations

import contextlib
import errno
import logging
from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.driving.stop_latch import LatchedStop
from talaia.gateway.persistence import read_whole, write_in_place

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["LeaseEpochs", "PersistentStops"]

log = logging.getLogger(__name__)
# So many numbers are reserved at once.
_BLOCK = 1000


class LeaseEpochs:
    """Numbers for leases that rise for ever.

    They are reserved on disk in blocks, so that a grant does not wait for the disk: a restart
    skips what was left of a block.
    """

    def __init__(self, path: Path) -> None:
        """Read what was reserved and reserve the next block.

        Where the disk does not take it nobody gets a lease until it does: a gateway that cannot
        let anybody drive still guards.

        Raises:
            SpoolError: the file is damaged.

        """
        self._path = path  # A small JSON file with one number: the highest that is reserved.
        # The file was read; before that no number may be given, or an epoch could come twice.
        self._read = False
        # Last given out, and last reserved; no number above the second is ever given.
        self._last = self._reserved = 0
        try:
            self._reserve_epochs()
        except OSError as error:
            log.warning("nobody can take a lease: %s: %s", path, error)

    def _reserve_epochs(self) -> None:
        if not self._read:
            self._last = self._reserved = read_whole(self._path, int, lambda: 0)
            self._read = True
        # On disk before it counts: after a crash the next run begins above everything given out
        # here.
        write_in_place(self._path, msgspec.json.encode(self._reserved + _BLOCK))
        self._reserved += _BLOCK

    def next_epoch(self) -> int:
        """Give a number higher than every one before.

        Raises:
            OSError: a new block could not be reserved; no number is given out.

        """
        # Not tried again at each grant while numbers are left: a full disk stops nobody yet.
        if self._last >= self._reserved:
            self._reserve_epochs()
        self._last += 1
        return self._last


class PersistentStops:
    """The devices that are stopped, by name."""

    def __init__(self, path: Path) -> None:
        """Read them.

        Raises:
            SpoolError: the file is damaged.

        """
        self._path = path
        # What stands on disk, by device; replaced whole after each successful write.
        self._stops: dict[str, LatchedStop] = {}
        # What the disk did not take; it is tried again.
        self._waiting: dict[str, LatchedStop] = {}
        # Who is said to have stopped everything where the file cannot be read; "" where it was.
        self._unread = ""
        try:
            self._stops = read_whole(path, dict[str, LatchedStop], dict)
        except OSError as error:
            log.warning("all that is driven begins with STOP: %s cannot be read: %s", path, error)
            # Fail-safe: what cannot be read may have held a STOP for any device.
            self._unread = f"the gateway, which cannot read its disk ({error.strerror})"
        with contextlib.suppress(OSError):
            if not path.exists():
                # So that there is room for the first STOP even when the disk is full by then.
                write_in_place(path, msgspec.json.encode(self._stops))

    def find_stop(self, device: str) -> LatchedStop | None:
        """Give who stopped a device, or none. Where that cannot be read, the gateway has."""
        # A waiting one is newer than the disk's.
        kept = self._waiting.get(device) or self._stops.get(device)
        return LatchedStop("", self._unread, 0) if kept is None and self._unread else kept

    @property
    def behind(self) -> bool:
        """Whether a STOP waits for the disk. May be asked from any thread."""
        return bool(self._waiting)

    def write_waiting(self) -> None:
        """Write what the disk did not take before; may block on it.

        Raises:
            OSError: it still does not.

        """
        # A copy: `write_stop` removes from it.
        for device, latched in list(self._waiting.items()):
            self.write_stop(device, latched)

    def write_stop(self, device: str, latched: LatchedStop | None) -> None:
        """Remember or forget one; may block on the disk.

        Raises:
            OSError: not written; what was remembered before stands on disk. A STOP waits in
                memory.

        """
        stops = dict(self._stops)
        if latched is None:
            stops.pop(device, None)
        else:
            # Waits until written, so that the disk's failure leaves it to `write_waiting`.
            stops[device] = self._waiting[device] = latched
        if self._unread:
            # Nothing is written over what may be there yet.
            raise OSError(errno.EIO, f"{self._path} cannot be read; mend the disk, then restart")
        write_in_place(self._path, msgspec.json.encode(stops))
        # Only now: an exception above leaves what stands on disk.
        self._stops = stops
        self._waiting.pop(device, None)
