"""A telescope on two axes, altitude and azimuth, as on a fork. Pure: time is given.

It refuses what would point it below its horizon limit or nearer to the Sun than its limit, on the
way as well as at the end, and stops by itself where tracking would lead there. With
`Limits.past_meridian` it turns over there, as a German mount.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from talaia.model.units.astronomy import (
    Horizontal,
    Observer,
    angular_separation,
    equatorial_to_horizontal,
    horizontal_to_equatorial,
    julian_day,
    sidereal_hours,
    sun_position,
)
from talaia.sim.observatory.models.pointing import Offset, PointingError, moved_place
from talaia.sim.observatory.models.ticket import Ticket

__all__ = ["STATES", "Limits", "Telescope"]

STATES = ("parked", "idle", "slewing", "tracking", "parking")


class Limits(NamedTuple):
    """Where it does not point, and how fast it turns.

    Attributes:
        horizon: lowest altitude of a target (°).
        sun: least distance from the Sun while that is up (°).
        rate: of each axis (°/s).
        past_meridian: it turns over so far beyond the meridian at the latest (h); none: never.
        flip: turning over takes so long (s).

    """

    horizon: float = 15.0
    sun: float = 30.0
    rate: float = 5.0
    past_meridian: float | None = None
    flip: float = 60.0


class Telescope:
    """The mount and its controller.

    Attributes:
        place: where it stands.
        at: where it points.
        state: one of `STATES`.

    """

    # Below `Limits.horizon`: a park is no target, and asks for no limit.
    PARK = Horizontal(10.0, 10.0)

    def __init__(self, place: Observer, unix_s: float, limits: Limits | None = None) -> None:
        """Start parked."""
        self.place = place
        self.limits = limits or Limits()
        self.at = self.PARK
        self.state = "parked"
        # A fault for tests: the motors do not move whatever is asked.
        self.stuck = False
        # Time of its clock (s, UTC).
        self._unix = unix_s
        # Right ascension (h) and declination (°) that it follows; none where it stands still.
        self._target: tuple[float, float] | None = None
        # Where a slew ends that follows no target, and the request under way.
        self._stand = self.PARK
        self._ticket = Ticket.done("")
        self._error = PointingError()
        # Of a mount that turns over: its side of the meridian, and how long it still turns (s).
        self.looks_east, self._turning_s = True, 0.0

    @property
    def jd(self) -> float:
        """Give the Julian day of its clock."""
        return julian_day(self._unix)

    @property
    def radec(self) -> tuple[float, float]:
        """Give where it points: right ascension (h) and declination (°) of date."""
        return horizontal_to_equatorial(self.at.alt, self.at.az, self.place, self.jd)

    @property
    def axis(self) -> tuple[float, float]:
        """Give where it really points (h, °, of date); it knows `radec` only."""
        return moved_place(*self.radec, self._error.at(self.at.alt))

    @property
    def sun(self) -> Horizontal:
        """Give where the Sun is."""
        return equatorial_to_horizontal(*sun_position(self.jd), self.place, self.jd)

    @property
    def target(self) -> tuple[float, float] | None:
        """Give what it tracks or slews to: right ascension (h), declination (°)."""
        return self._target

    # ── what may be asked ──

    def goto(self, ra: float, dec: float) -> Ticket:
        """Slew to a place in the sky and track it (h, °; equinox of date)."""
        if not 0.0 <= ra < 24.0:
            return Ticket.refused(f"RA {ra:g} h: expected 0 to 24 h")
        if not -90.0 <= dec <= 90.0:
            return Ticket.refused(f"Dec {dec:g}: expected -90 to 90 °")
        return self._begin_slew(equatorial_to_horizontal(ra, dec, self.place, self.jd), (ra, dec))

    def goto_altaz(self, alt: float, az: float) -> Ticket:
        """Slew to a place above the horizon (°) and stand there."""
        if not -90.0 <= alt <= 90.0 or not 0.0 <= az <= 360.0:
            return Ticket.refused(f"Alt {alt:g}, Az {az:g}: expected -90 to 90 and 0 to 360 °")
        return self._begin_slew(Horizontal(alt, az % 360.0), None)

    def _begin_slew(self, to: Horizontal, target: tuple[float, float] | None) -> Ticket:
        if self.state in ("parked", "parking"):
            return Ticket.refused("the telescope is parked; unpark it first")
        problem = self._target_problem(to)
        if problem:
            return Ticket.refused(problem)
        self._ticket.end_with("another command came", good=False)
        self._target = target
        self._stand = to
        self.state = "slewing"
        self._ticket = Ticket()
        if target is not None and self.limits.past_meridian is not None:
            east = self._hours_past_meridian(target) < 0.0
            self._turning_s = self.limits.flip if east is not self.looks_east else 0.0
            self.looks_east = east
        return self._ticket

    def _hours_past_meridian(self, target: tuple[float, float]) -> float:
        sidereal = sidereal_hours(self.jd, self.place.longitude)
        return (sidereal - target[0] + 12.0) % 24.0 - 12.0

    def _target_problem(self, to: Horizontal) -> str:
        if to.alt < self.limits.horizon:
            return (
                f"the target stands at {to.alt:.1f} °, below the limit of {self.limits.horizon:g} °"
            )
        away = angular_separation(to, self.sun)
        # Below the horizon the Earth is in the way, but not by much: twilight counts as day.
        if self.sun.alt > -6.0:
            if away < self.limits.sun:
                least = self.limits.sun
                return f"the target is {away:.0f} ° from the Sun; at least {least:g} ° is needed"
            if self._passes_sun(to):
                return f"the way to the target passes the Sun within {self.limits.sun:g} °"
        return ""

    def _passes_sun(self, to: Horizontal) -> bool:
        now = self.at
        if angular_separation(now, self.sun) < self.limits.sun:
            return False  # it is there already; every way out is better than staying
        # Steps of 2° are far finer than the Sun's limit, so that no passage falls between two.
        while _angle_between(now, to) > 0.5:
            now = _moved_axes(now, to, 2.0)
            if angular_separation(now, self.sun) < self.limits.sun:
                return True
        return False

    def park(self) -> Ticket:
        """Go to the park position, and refuse to slew until it is unparked."""
        if self.state == "parked":
            return Ticket.done("the telescope is parked")
        self._ticket.end_with("the telescope parks", good=False)
        self._target, self._stand = None, self.PARK
        self.state = "parking"
        self._ticket = Ticket()
        return self._ticket

    def unpark(self) -> Ticket:
        """Let it move again; a park under way is stopped or waited for first."""
        if self.state == "parking":
            return Ticket.refused("the telescope is parking; stop it or wait until it is parked")
        if self.state == "parked":
            self.state = "idle"
        return Ticket.done("the telescope is not parked")

    def set_tracking(self, on: bool) -> Ticket:  # noqa: FBT001 - a switch, as the service has it
        """Follow the sky from here, or stand."""
        if self.state in ("parked", "parking"):
            return Ticket.refused("the telescope is parked; unpark it first")
        if self.state == "slewing":
            return Ticket.refused("the telescope slews")
        if on and (problem := self._target_problem(self.at)):
            return Ticket.refused(problem)
        self._target = self.radec if on else None
        self.state = "tracking" if on else "idle"
        return Ticket.done("the telescope tracks" if on else "the telescope stands")

    def sync(self, ra: float, dec: float) -> Ticket:
        """Hear where it really points (h, °, of date); nothing moves."""
        if self.state != "tracking":
            return Ticket.refused("the telescope does not track; only a tracking one can be synced")
        if not 0.0 <= ra < 24.0 or not -90.0 <= dec <= 90.0:
            return Ticket.refused(f"RA {ra:g} h, Dec {dec:g} °: expected 0 to 24 h and -90 to 90 °")
        to = equatorial_to_horizontal(ra, dec, self.place, self.jd)
        if angular_separation(self.at, to) > 5.0:
            return Ticket.refused("the place is more than 5 ° from where the telescope points")
        axis = self.axis
        self._target, self.at = (ra, dec), to
        now = self.axis
        east = (axis[0] - now[0] + 12.0) % 24.0 - 12.0
        along = math.cos(math.radians(dec))
        self._error.correct(Offset(east * 15.0 * 3600.0 * along, (axis[1] - now[1]) * 3600.0))
        return Ticket.done("the telescope is synced")

    def guide(self, east: float, north: float) -> Ticket:
        """Nudge it by some arc seconds; what it says stays as it was."""
        if self.state != "tracking":
            return Ticket.refused("the telescope does not track")
        if not abs(east) <= 60.0 or not abs(north) <= 60.0:
            return Ticket.refused(f"{east:g}, {north:g}: expected at most 60 arc seconds each way")
        if not self.stuck:
            self._error.correct(Offset(east, north))
        return Ticket.done(f"the telescope is nudged by {east:.2f} {north:.2f}")

    def stop(self) -> Ticket:
        """Stop every motion, tracking as well. A park that is stopped leaves it unparked."""
        if self.state != "parked":
            self.state = "idle"
        self._target = None
        self._ticket.end_with("the telescope was stopped", good=False)
        return Ticket.done("the telescope is stopped")

    # ── time ──

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass."""
        self._unix = unix_s
        if self.state in ("slewing", "parking"):
            # The sky turns while the mount slews: the goal is reckoned anew at each step.
            to = self._stand
            if self._target is not None:
                to = equatorial_to_horizontal(*self._target, self.place, self.jd)
            if not self.stuck:
                self.at = _moved_axes(self.at, to, self.limits.rate * seconds)
            self._turning_s = max(0.0, self._turning_s - seconds)
            # `_moved_axes` ends at the goal itself; the rest is rounding.
            if self._turning_s <= 0.0 and _angle_between(self.at, to) < 1e-6:
                self._finish_slew()
        elif self.state == "tracking" and self._target is not None:
            to = equatorial_to_horizontal(*self._target, self.place, self.jd)
            problem = self._problem_of_tracking(to)
            if problem:
                self._target, self.state = None, "idle"
                self._ticket.end_with(problem, good=False)
            else:
                self.at = to
                self._error.track(seconds)

    def _problem_of_tracking(self, to: Horizontal) -> str:
        if to.alt < self.limits.horizon:
            return "tracking ended at the horizon limit"
        if self.sun.alt > -6.0 and angular_separation(to, self.sun) < self.limits.sun:
            return "tracking ended at the Sun's limit"
        past = self.limits.past_meridian if self.looks_east else None
        if past is not None and self._hours_past_meridian(self._target or (0.0, 0.0)) > past:
            return "tracking ended at the meridian limit"
        return ""

    def _finish_slew(self) -> None:
        if self.state == "parking":
            self.state = "parked"
            self._ticket.end_with("the telescope is parked", good=True)
            return
        self.state = "tracking" if self._target is not None else "idle"
        self._ticket.end_with(
            f"the telescope is at Alt:{self.at.alt:f} Az:{self.at.az:f}", good=True
        )


def _angle_between(now: Horizontal, to: Horizontal) -> float:
    # Both axes turn at once, so the longer way decides; this is no angle on the sphere.
    return max(abs(to.alt - now.alt), abs(_shortest_turn(now.az, to.az)))


def _shortest_turn(from_az: float, to_az: float) -> float:
    # The shorter way round: -180 to 180°.
    return (to_az - from_az + 180.0) % 360.0 - 180.0


def _moved_axes(now: Horizontal, to: Horizontal, reach: float) -> Horizontal:
    """Move both axes at once, each by ``reach`` (°) at the most."""
    alt, az = to.alt - now.alt, _shortest_turn(now.az, to.az)
    if max(abs(alt), abs(az)) <= reach:
        return to
    return Horizontal(
        now.alt + math.copysign(min(abs(alt), reach), alt),
        (now.az + math.copysign(min(abs(az), reach), az)) % 360.0,
    )
