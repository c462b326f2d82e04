"""The last seconds of a camera's film, from a picture on that needs none before it. Pure."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from talaia.wire.frames import PictureFrame

__all__ = ["FilmRing"]

# Bytes that Python keeps beside each picture's data, about.
_OVERHEAD = 300


class FilmRing:
    """Holds whole runs of pictures: each begins with one that needs none before it.

    It reaches back at least as far as it is to, if that many bytes are allowed.
    """

    def __init__(self, keep_us: int, max_bytes: int) -> None:
        """Hold the last ``keep_us``, in at most ``max_bytes``; nothing for 0."""
        self._keep_us = keep_us  # µs of film to hold.
        self._max_bytes = max_bytes  # The bound that wins where both cannot be kept.
        # Oldest first; each begins with a key picture.
        self._runs: deque[list[PictureFrame]] = deque()
        self.bytes = 0  # Data and overhead of all that is held.

    def resize(self, keep_us: int, max_bytes: int) -> None:
        """Hold another length from here on; what is too much goes with the next picture."""
        self._keep_us, self._max_bytes = keep_us, max_bytes

    def __len__(self) -> int:
        """Count the pictures."""
        return sum(map(len, self._runs))

    def add_picture(self, picture: PictureFrame) -> bool:
        """Take the newest picture; False when there is no beginning that it could follow."""
        if picture.key:
            self._runs.append([])
        elif not self._runs:
            return False
        self._runs[-1].append(picture)
        self.bytes += len(picture.data) + _OVERHEAD
        self.trim_runs(picture.mono_us)
        return bool(self._runs)

    def trim_runs(self, now_us: int) -> None:
        """Let go of the runs that are not needed to reach back far enough, or are too much."""
        runs = self._runs
        # Compared with the second run: the first goes only when the next still reaches back far
        # enough.
        while len(runs) > 1 and now_us - runs[1][0].mono_us >= self._keep_us:
            self._drop_oldest()
        while runs and (
            self.bytes > self._max_bytes or now_us - runs[-1][-1].mono_us > self._keep_us
        ):
            self._drop_oldest()

    def drain_pictures(self) -> list[PictureFrame]:
        """Give all that is held, in order, and hold nothing."""
        taken = [picture for run in self._runs for picture in run]
        self._runs.clear()
        self.bytes = 0
        return taken

    def _drop_oldest(self) -> None:
        self.bytes -= sum(len(packet.data) + _OVERHEAD for packet in self._runs.popleft())
