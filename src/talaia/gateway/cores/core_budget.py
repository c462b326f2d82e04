"""How much of the cores pictures may take, whose turn it is, and how large they are made. Pure.

A picture takes what it takes: of a small camera some milliseconds, of a large one a tenth of a
second, thirty times a second. So the time of all pictures together has a limit, and that limit
falls while the event loop, on which driving and samples go, is late. Within it cameras take turns
by the processor time that each had. One that would come too seldom is made smaller.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Collection

__all__ = ["GOOD_HZ", "LARGEST_DIVISOR", "LEAST_ROOM", "CoreBudget", "PictureSize", "Turns"]

# Of all cores at the most; and never less than this (cores): a small camera at 30 Hz, twice.
_SHARE, LEAST_ROOM = 0.5, 0.25
# So much may be made up for at once (µs): pictures of several cameras come at the same moment.
_BURST_US = 50_000
# The event loop is late from here on (µs), and well up to here: driving has 20 ms for all its way.
_LATE_US, _WELL_US = 10_000, 5_000
# Down in larger steps than up, and no faster than this (µs): what one does must be seen first.
_FEWER, _MORE = 0.8, 1.1
_DOWN_US, _UP_US = 300_000, 2_000_000
# Below this a camera is made smaller; and larger again where it would still come so much faster.
GOOD_HZ, _AGAIN = 10.0, 1.3
LARGEST_DIVISOR = 4
# What is judged at a time (µs, pictures), and how many such times there must be room for a larger
# one.
_WINDOW_US, _WINDOW_PICTURES, _CALM_WINDOWS = 1_000_000, 3, 5
# A smaller size that is not so much cheaper (factor) is given up, and not tried for a while.
_HELPS, _NOT_AGAIN_WINDOWS = 1.2, 60


class CoreBudget:
    """The limit for all pictures of a gateway together."""

    def __init__(self, cores: float) -> None:
        """Begin with half of so many cores."""
        self._most = max(LEAST_ROOM, cores * _SHARE)
        self.room = self._most  # What pictures may take now (cores).
        # When the next picture may begin (monotonic µs).
        self._free_us = 0
        self._late_us = 0  # When the loop was last late, or the room last changed (µs).
        self._well_since_us = 0

    def note_lateness(self, late_us: int, now_us: int) -> None:
        """Take by how much the event loop was late just now (µs)."""
        if late_us > _LATE_US:
            self._well_since_us = now_us
            if now_us - self._late_us >= _DOWN_US:
                self._late_us = now_us
                self.room = max(LEAST_ROOM, self.room * _FEWER)
        elif late_us > _WELL_US:
            self._well_since_us = now_us
        elif now_us - self._well_since_us >= _UP_US:
            self._well_since_us = now_us
            self.room = min(self._most, self.room * _MORE)

    def spend(self, began_us: int, cpu_us: int) -> None:
        """Take what a picture cost (µs of a processor) that was begun then."""
        self._free_us = max(self._free_us, began_us - _BURST_US) + round(cpu_us / self.room)

    def rest_us(self, now_us: int) -> int:
        """Give how long no picture may begin from now on (µs)."""
        return max(0, self._free_us - now_us)


class Turns:
    """Whose picture is next: of those that wait the camera that had the least processor time.

    Start-time fair queueing: one that had nothing to show for a while has saved nothing up.
    """

    def __init__(self) -> None:
        """Nobody has had anything."""
        self._had: dict[str, int] = {}  # By stream: when its next turn is (µs of processor time).
        self._now = 0  # The turn of whoever was last chosen.

    def choose(self, waiting: Collection[str]) -> str:
        """Choose one of those that wait, of equals the first."""
        chosen = min(waiting, key=lambda stream: max(self._now, self._had.get(stream, 0)))
        self._now = max(self._now, self._had.get(chosen, 0))
        return chosen

    def spend(self, stream: str, cpu_us: int) -> None:
        """Take what the picture of the one that was chosen has cost (µs of a processor)."""
        self._had[stream] = max(self._now, self._had.get(stream, 0)) + cpu_us


class PictureSize:
    """By what one camera's pictures are made smaller, so that they come often enough."""

    def __init__(self) -> None:
        """Begin with the camera's own size."""
        self.divisor = 1  # Width and height are divided by it.
        self._since_us = 0  # When this window began (µs).
        self._made = self._lost = self._cost_us = 0  # Pictures and processor time within it.
        self._calm = 0  # Windows in which a larger size would have come often enough.
        # What a picture cost (µs) in the size that was just given up; 0: none was.
        self._before_us = 0.0
        self._settled = 0  # Windows for which it is not made smaller, since that did not help.

    def note_picture(self, now_us: int, cpu_us: int, *, lost: int, room: float) -> None:
        """Take a picture that was made.

        Args:
            now_us: monotonic (µs).
            cpu_us: what it cost (µs of a processor).
            lost: pictures that came since the one before and were not made, for want of time.
            room: what all pictures may take (cores).

        """
        if not self._since_us or now_us - self._since_us > 5 * _WINDOW_US:
            # Nobody looked for a while.
            self._begin(now_us)
        self._made += 1
        self._lost += lost
        self._cost_us += cpu_us
        lasted_us = now_us - self._since_us
        if lasted_us >= _WINDOW_US and self._made >= _WINDOW_PICTURES:
            self._judge(self._made * 1e6 / lasted_us, lasted_us, room)
            self._begin(now_us)

    def _begin(self, now_us: int) -> None:
        self._since_us, self._made, self._lost, self._cost_us = now_us, 0, 0, 0

    def _judge(self, rate_hz: float, lasted_us: int, room: float) -> None:
        self._settled = max(0, self._settled - 1)
        cost_us = self._cost_us / self._made
        before_us, self._before_us = self._before_us, 0.0
        if before_us and before_us < cost_us * _HELPS:
            # What is dear is not the size; back, for a larger one costs no more.
            self.divisor, self._settled = self.divisor - 1, _NOT_AGAIN_WINDOWS
            return
        if self._lost and rate_hz < GOOD_HZ:
            self._calm = 0
            if self.divisor < LARGEST_DIVISOR and not self._settled:
                self._before_us = cost_us
                self.divisor += 1
            return
        if self.divisor > 1 and self._larger_hz(lasted_us, room) >= GOOD_HZ * _AGAIN:
            self._calm += 1
            if self._calm >= _CALM_WINDOWS:
                self._calm, self.divisor = 0, self.divisor - 1
        else:
            self._calm = 0

    def _larger_hz(self, lasted_us: int, room: float) -> float:
        """Give how often the next larger size would come at the least, were all of it dearer."""
        share = self._cost_us / lasted_us if self._lost else room
        dearer = (self.divisor / (self.divisor - 1)) ** 2
        return share * 1e6 / (self._cost_us / self._made * dearer)
