"""Turns a dome to where its telescope points, or is on its way to; holds exposures meanwhile. Pure.

A dome does not chase a telescope that slews. It turns to where the slew ends, at the same time, so
that the slower of the two is waited for and not the sum of both.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND
from talaia.model.interlocks.interlock import Step

if TYPE_CHECKING:
    from talaia.model.interlocks.enclosure import Follow

__all__ = ["FOLLOW_LABEL", "Follower", "Hold", "apart_of", "hold_of"]

# What turns a dome is done in this name, with the dome's. A newer one takes an older one's place,
# and it holds nobody up.
FOLLOW_LABEL = "follow "


class Hold(NamedTuple):
    """Why an exposure is not begun yet; ``final`` when waiting would not help."""

    why: str
    wait_s: float
    final: bool = False


def hold_of(
    rule: Follow, *, is_open: bool | None, closed: bool, moving: bool | None, apart: float | None
) -> Hold | None:
    """Say what an exposure has to wait for, or none when telescope and dome are in place.

    Args:
        rule: the description.
        is_open: what the sensor of ``rule.open`` says; true where there is none.
        closed: the roof is certainly closed, and does not move.
        moving: the telescope is on its way; none when it says nothing.
        apart: between telescope and slit (°); none when that is unknown. Zero where the dome has
            no reason to follow, because the telescope does not track.

    """
    if is_open is not True:
        why = "it is closed" if closed else "waiting until it is open"
        return Hold(why, rule.wait, final=closed)
    if moving is not False:
        return Hold("waiting for the telescope, which is on its way", rule.wait)
    if apart is None:
        return Hold("waiting to hear where telescope and dome stand", rule.wait)
    if apart > rule.within:
        return Hold(f"waiting for the dome, which is {apart:.0f}° from the telescope", rule.wait)
    return None


def apart_of(target: float | None, azimuth: float | None) -> float | None:
    """Give the angle between two azimuths (°), none when one is unknown."""
    if target is None or azimuth is None:
        return None
    return abs((target - azimuth + 180.0) % 360.0 - 180.0)


class SlewEnd(NamedTuple):
    """Where a slew under way leads to.

    Attributes:
        azimuth: of its end (°).
        since_ns: when it was begun (monotonic).
        over: its command has ended.

    """

    azimuth: float
    since_ns: int
    over: bool = False


class Follower:
    """Turns a dome after a telescope that stands on its target, or slews to it.

    Attributes:
        rule: see `Follow`.

    """

    def __init__(self, rule: Follow) -> None:
        """Have asked nothing yet."""
        self.rule = rule
        self._asked_ns: int | None = None
        self._asked_azimuth: float | None = None
        self._slew: SlewEnd | None = None

    def begin_slew(self, azimuth: float, now_ns: int) -> None:
        """Hear that the telescope was sent to an azimuth (°): the dome is due there at once."""
        self._slew = SlewEnd(azimuth, now_ns)
        # What was asked for the former target is no reason to wait for this one.
        self._asked_ns = None

    def end_slew(self) -> None:
        """Hear that a command of the telescope has ended, however it did."""
        if self._slew is not None:
            self._slew = self._slew._replace(over=True)

    def next_step(
        self,
        target: float | None,
        azimuth: float | None,
        now_ns: int,
        *,
        settled: bool,
        moving: bool | None = None,
    ) -> Step | None:
        """Give the command that is due, if any.

        Args:
            target: where the telescope points (°), none when unknown.
            azimuth: where the dome's slit is (°), none when unknown.
            now_ns: monotonic.
            settled: the telescope stands on its target, not on the way to it.
            moving: the telescope is on its way; none when it says nothing.

        """
        slew = self._slew
        if slew is not None and target is not None:
            # Some mounts answer at once and slew then; one that never arrives is waited for no
            # longer than an exposure is.
            ended = slew.over and moving is not True
            if ended or now_ns - slew.since_ns > round(self.rule.wait * SECOND):
                self._slew = None
            else:
                # Of a mount that says nothing the dome turns after nothing, as ever.
                target, settled = slew.azimuth, True
        apart = apart_of(target, azimuth)
        if not settled or target is None or apart is None or apart <= self.rule.within:
            return None
        every = round(self.rule.every * SECOND)
        if self._asked_ns is not None and now_ns - self._asked_ns < every:
            return None
        self._asked_ns = now_ns
        asked = self._asked_azimuth
        if asked is None or (apart_of(target, asked) or 0.0) > self.rule.within:
            # A dome under way is not sent anew after each tenth of a degree that the sky turns.
            self._asked_azimuth = asked = round(target % 360.0, 1)
        args = {self.rule.argument: asked}
        return Step(command=self.rule.command, args={**args}, required=False)
