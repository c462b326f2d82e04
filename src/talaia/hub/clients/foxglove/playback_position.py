"""Which window of the past one client plays, and where in it the playing stands. Pure."""

from __future__ import annotations

import math
from datetime import UTC, datetime
from typing import TYPE_CHECKING, NamedTuple

from talaia.wire.foxglove.codec import PlaybackStatus

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.wire.foxglove.client_messages import FoxglovePlayback

__all__ = ["PlaybackPosition", "PlaybackWindow", "read_window"]

_MICROS = 1_000_000
# Times faster or slower than this are played at this.
_LEAST_SPEED, _MOST_SPEED = 0.01, 1000.0


class PlaybackWindow(NamedTuple):
    """A window of the past, both ends included (µs, UTC)."""

    from_us: int
    to_us: int


def read_window(query: Mapping[str, str], now_us: int) -> PlaybackWindow | str | None:
    """Read the window of an address (``from=``, ``to=``); or say what is wrong with it.

    Without ``from`` there is none: what comes is live. Without ``to`` it ends now.
    """
    if "from" not in query:
        return "to= takes from= beside it" if "to" in query else None
    # Both by the same rule, so that what is wrong names its place.
    window = []
    for name in ("from", "to"):
        time_us = now_us if name not in query else _read_time(query[name])
        if time_us is None:
            return f"{name}= is a time with its zone, such as 2026-11-23T10:00:00Z"
        window.append(time_us)
    if not 0 <= window[0] < window[1]:
        return "from= is before to="
    # What is still to come cannot be played.
    return PlaybackWindow(window[0], min(window[1], max(now_us, window[0] + 1)))


def _read_time(text: str) -> int | None:
    try:
        # A plus sign in an address is read as a space.
        read = datetime.fromisoformat(text.replace(" ", "+"))
    except ValueError:
        return None
    if read.tzinfo is None:
        return None
    # In whole numbers: a float has no microseconds any more after some decades.
    since = read.astimezone(UTC) - datetime(1970, 1, 1, tzinfo=UTC)
    return (since.days * 86_400 + since.seconds) * _MICROS + since.microseconds


class PlaybackPosition:
    """Where playing stands: paused at the beginning at first. ``now_ns`` is monotonic."""

    def __init__(self, window: PlaybackWindow) -> None:
        """Stand at the beginning of ``window``."""
        self.window = window
        self.playing = False
        self.speed = 1.0
        # Where it stood, and when that was.
        self._base_us = window.from_us
        # Means nothing while it stands still.
        self._base_ns = 0

    def status_at(self, now_ns: int) -> PlaybackStatus:
        """Give the word of the protocol for it."""
        if self.time_at(now_ns) >= self.window.to_us:
            return PlaybackStatus.ENDED
        return PlaybackStatus.PLAYING if self.playing else PlaybackStatus.PAUSED

    def time_at(self, now_ns: int) -> int:
        """Give where it stands (µs, UTC)."""
        passed = (now_ns - self._base_ns) / 1000 * self.speed if self.playing else 0.0
        return min(self._base_us + round(passed), self.window.to_us)

    def control(self, asked: FoxglovePlayback, now_ns: int) -> None:
        """Do what a client asks, within the window and the speeds that there are."""
        at_us = self.time_at(now_ns)
        if asked.seek_ns is not None:
            at_us = asked.seek_ns // 1000
        # What is no number changes nothing.
        if math.isfinite(asked.speed) and asked.speed > 0:
            self.speed = min(max(asked.speed, _LEAST_SPEED), _MOST_SPEED)
        self.playing = asked.play
        # From now on by the new speed.
        self.move_to(at_us, now_ns)

    def move_to(self, time_us: int, now_ns: int) -> None:
        """Go on from another time of the window."""
        self._base_us = min(max(time_us, self.window.from_us), self.window.to_us)
        self._base_ns = now_ns

    def stand_at_end(self) -> None:
        """All has been played."""
        self.playing = False
        self._base_us = self.window.to_us
