"""Blurs on one camera's pictures what nobody is to recognize. Any thread.

What is found on a picture is blurred on it, with some around it, and for a while after it is not
found any more: a detector misses now and then what is there. A picture that could not be looked at
is not given: whoever asks for it is told why instead.
"""

from __future__ import annotations

import itertools
import threading
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.gateway.video.pixels import Pixels
from talaia.objects.errors import DetectorError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from talaia.model.detection import Blur
    from talaia.objects.detection import Detection

__all__ = ["CameraBlur", "blur_area"]

# So many areas of one colour are left of what is blurred, across and down. With fewer than about
# eight across a face nobody tells whose it is, and neither does a network that was taught to.
CELLS = 4
# Blurred beside what was found, on each side: of its size, and more for each second since (a face
# that crosses the picture in a second goes by some ten times its own width).
AROUND, AROUND_EACH_S = 0.3, 2.0
# As many at once that looking at one after the other leads nowhere.
MOST_SEEN = 200


class _Seen(NamedTuple):
    """What was found on one picture, and when that came (monotonic µs)."""

    at_us: int
    things: Sequence[Detection]


class CameraBlur:
    """One camera's pictures, blurred; pictures come roughly in order."""

    def __init__(self, blur: Blur) -> None:
        """Blur what the description says."""
        self._blur = blur
        self._hold_us = round(blur.hold * 1e6)
        self._period_us = round(1e6 / blur.looks) if blur.looks else 0
        # One at a time: those who look at the gateway may want the very picture that is under way.
        self._turn = threading.Lock()
        # What was found lately, in the order in which it was looked at.
        self._seen: deque[_Seen] = deque(maxlen=MOST_SEEN)
        # When a picture was looked at last and well; None before, and after one that was not.
        self._looked_us: int | None = None
        # The newest that was blurred, and when it came; several want the same.
        self._newest: tuple[int, Pixels] | None = None

    def cover(
        self,
        rgb: NDArray[np.uint8],
        at_us: int,
        find: Callable[[Blur, NDArray[np.uint8]], Sequence[Detection]],
    ) -> Pixels:
        """Give a picture as it may leave the gateway.

        Args:
            rgb: rows × columns × 3; it stays as it is.
            at_us: when it came (monotonic µs).
            find: finds on a picture what is to be blurred, or raises `DetectorError`.

        Raises:
            DetectorError: it may not leave, for nobody could look at it.

        """
        with self._turn:
            if self._newest is not None and self._newest[0] == at_us:
                return self._newest[1]
            if self._is_look_due(at_us):
                self._look_for_faces(rgb, at_us, find)
            shown = np.array(rgb)
            for seen in self._seen:
                gone_us = abs(at_us - seen.at_us)
                if gone_us > self._hold_us:
                    continue
                around = AROUND + AROUND_EACH_S * gone_us / 1e6
                for thing in seen.things:
                    blur_area(shown, thing, around)
            height, width = shown.shape[:2]
            pixels = Pixels("RGB", width, height, shown)
            self._newest = (at_us, pixels)
            return pixels

    def _is_look_due(self, at_us: int) -> bool:
        looked_us = self._looked_us
        # A picture of before the last look is looked at, too.
        return looked_us is None or not 0 <= at_us - looked_us < self._period_us

    def _look_for_faces(
        self,
        rgb: NDArray[np.uint8],
        at_us: int,
        find: Callable[[Blur, NDArray[np.uint8]], Sequence[Detection]],
    ) -> None:
        # Until it has gone well: the pictures after one that failed may not leave by what was found
        # before it.
        self._looked_us = None
        try:
            things = find(self._blur, rgb)
        except DetectorError as error:
            raise DetectorError(f"no picture leaves, for it cannot be blurred: {error}") from error
        self._looked_us = at_us
        self._seen.append(_Seen(at_us, things))


def blur_area(rgb: NDArray[np.uint8], thing: Detection, around: float) -> None:
    """Leave of a thing, and of so much around it (of its size), a few areas of one colour."""
    height, width = rgb.shape[:2]
    top, bottom = _span(thing.top, thing.bottom, height, around)
    left, right = _span(thing.left, thing.right, width, around)
    rows = np.linspace(top, bottom, CELLS + 1).astype(int)
    columns = np.linspace(left, right, CELLS + 1).astype(int)
    for upper, lower in itertools.pairwise(rows):
        for first, last in itertools.pairwise(columns):
            cell = rgb[upper:lower, first:last]
            if cell.size:
                cell[:] = cell.reshape(-1, 3).mean(axis=0)


def _span(low: float, high: float, size: int, around: float) -> tuple[int, int]:
    more = (high - low) * around
    # Rounded outwards: no line of it is left at the edge.
    first = int(np.floor(max(0.0, low - more) * size))
    return first, max(first, int(np.ceil(min(1.0, high + more) * size)))
