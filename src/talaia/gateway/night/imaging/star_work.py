"""Focus and plate solving for a night: the steps are pure, the pictures are reckoned elsewhere.

What takes half a second of numbers runs in an executor that whoever builds these hands over, a pool
of processes: the loop that drives and guards never waits for it.
"""

from __future__ import annotations

import asyncio
import math
from typing import TYPE_CHECKING, NamedTuple, Protocol

from talaia.gateway.night.imaging.star_parts import DeviceFailed, FocusOutlook, PartOutcome
from talaia.imaging.centring import Centring
from talaia.imaging.focus_run import FocusRun, FocusSettings
from talaia.imaging.frame_tasks import measure_focus, solve_frame
from talaia.model.units.astronomy import J2000, julian_day, precess_coordinates

if TYPE_CHECKING:
    from collections.abc import Callable
    from concurrent.futures import Executor

    from talaia.clock import Clock
    from talaia.gateway.night.imaging.star_parts import FieldCentre

__all__ = ["CentringSolver", "FocusRules", "FocusRunner", "StarDevices"]


def _as_long(_filter_name: str) -> float:
    return 1.0


class StarDevices(Protocol):
    """What the parts ask of the devices, by commands as a person gives them.

    Each raises `DeviceFailed` in the device's words, and ends within the command's own time.
    """

    async def slew_to(self, ra: float, dec: float) -> None:
        """Send the telescope to a place of date (h, °), and wait until it tracks there."""
        ...

    async def take_frame(self, seconds: float) -> bytes:
        """Expose, and give the FITS file."""
        ...

    async def move_focuser(self, position: float) -> None:
        """Move the focuser (steps), and wait until it stands."""
        ...

    def focuser_position(self) -> float | None:
        """Give where the focuser stands (steps); none when that is not known."""
        ...

    def tube_temperature(self) -> float | None:
        """Give how warm the tube is (°C); none when that is not known."""
        ...


class CentringSolver:
    """A `PlateSolver`."""

    present = True

    def __init__(
        self,
        devices: StarDevices,
        work: Executor,
        clock: Clock,
        *,
        seconds: float = 5.0,
        longer: Callable[[str], float] = _as_long,
    ) -> None:
        """Take the devices, who reckons, and the time.

        Each picture is exposed so many ``seconds``, and ``longer`` times that through a filter.
        """
        self._devices, self._work, self._clock = devices, work, clock
        self._seconds, self._longer = seconds, longer

    async def centre_field(self, centre: FieldCentre) -> PartOutcome:
        """See `PlateSolver.centre_field`; the telescope tracks the field already."""
        centring = Centring(centre.ra, centre.dec, tolerance=centre.within)
        loop = asyncio.get_running_loop()
        place: tuple[float, float] | None = None
        seconds = self._seconds * self._longer(centre.filter)
        while True:
            try:
                data = await self._devices.take_frame(seconds)
            except DeviceFailed as error:
                return PartOutcome(good=False, message=f"no picture to solve: {error}")
            solved = await loop.run_in_executor(
                self._work, solve_frame, data, centre.ra, centre.dec
            )
            if solved.problem:
                return PartOutcome(good=False, message=f"not solved: {solved.problem}")
            step = centring.add_solution(solved.ra, solved.dec)
            if step.done:
                words = f"centred to {step.error:.1f}″"
                seeing = solved.fwhm if math.isfinite(solved.fwhm) else None
                return PartOutcome(good=True, message=words, place=place, seeing=seeing)
            if step.problem:
                return PartOutcome(good=False, message=f"not centred: {step.problem}")
            jd = julian_day(self._clock.wall_ns() / 1e9)
            place = precess_coordinates(step.ra / 15.0, step.dec, J2000, jd)
            try:
                await self._devices.slew_to(*place)
            except DeviceFailed as error:
                return PartOutcome(good=False, message=f"not centred: {error}")


# What a thermometer trembles is no trend over less (s).
_TREND_S = 900.0


class FocusRules(NamedTuple):
    """When a run is due, and how it goes.

    Attributes:
        every: after so long (s).
        degrees: after the tube has changed by so much (°C).
        seconds: each picture is exposed.
        longer: gives so many times as long, for a filter.
        settings: see `FocusSettings`.

    """

    every: float = 7200.0
    degrees: float = 1.5
    seconds: float = 4.0
    longer: Callable[[str], float] = _as_long
    settings: FocusSettings = FocusSettings()


class _LastRun(NamedTuple):
    filter_name: str
    celsius: float | None
    time: float


class FocusRunner:
    """An `AutoFocuser`."""

    present = True

    def __init__(
        self, devices: StarDevices, work: Executor, clock: Clock, rules: FocusRules | None = None
    ) -> None:
        """Take the devices, who reckons, the time, and the rules."""
        self._devices, self._work, self._clock = devices, work, clock
        self._rules = rules or FocusRules()
        self._last: _LastRun | None = None

    def is_due(self, filter_name: str, temperature: float | None, time: float) -> bool:
        """See `AutoFocuser.is_due`; ``time`` on the monotonic clock (s)."""
        last, rules = self._last, self._rules
        if last is None or last.filter_name != filter_name or time - last.time >= rules.every:
            return True
        if temperature is None or last.celsius is None:
            return False
        return abs(temperature - last.celsius) >= rules.degrees

    def outlook(self, temperature: float | None, time: float) -> FocusOutlook | None:
        """See `AutoFocuser.outlook`; ``time`` on the monotonic clock (s)."""
        last, rules = self._last, self._rules
        if last is None:
            return None
        ago, every = time - last.time, rules.every
        again = f"{every / 3600.0:.1f} h after the last one"
        if temperature is not None and last.celsius is not None and ago >= _TREND_S:
            changed = temperature - last.celsius
            # As it has changed since the last run, so it goes on.
            due = ago * rules.degrees / max(abs(changed), 1e-9)
            if due < every:
                words = "cools" if changed < 0 else "grows warmer"
                rate = abs(changed) / ago * 3600.0
                every, again = due, f"the tube {words} by {rate:.1f} °C an hour"
        return FocusOutlook(last.filter_name, ago, every, again)

    async def run_focus(self, filter_name: str) -> PartOutcome:
        """See `AutoFocuser.run_focus`; after a failure the focuser is where it was."""
        # Also after one that fails: it is not tried again before each block.
        self._last = _LastRun(
            filter_name, self._devices.tube_temperature(), self._clock.monotonic_ns() / 1e9
        )
        start = self._devices.focuser_position()
        if start is None:
            return PartOutcome(good=False, message="no focus: where the focuser stands is unknown")
        run = FocusRun(start, self._rules.settings)
        try:
            return await self._follow_run(run, self._rules.longer(filter_name))
        except DeviceFailed as error:
            return PartOutcome(good=False, message=f"no focus: {error}")

    async def _follow_run(self, run: FocusRun, longer: float) -> PartOutcome:
        loop = asyncio.get_running_loop()
        while True:
            step = run.next_step()
            for position in step.moves:
                await self._devices.move_focuser(position)
            if not step.measure:
                break
            data = await self._devices.take_frame(self._rules.seconds * longer)
            seen = await loop.run_in_executor(self._work, measure_focus, data)
            if seen.problem:
                raise DeviceFailed(f"the picture cannot be read: {seen.problem}")
            run.add_measurement(seen.hfr, seen.stars)
        if step.problem:
            return PartOutcome(good=False, message=f"no focus: {step.problem}")
        fit = run.fit
        said = f"focus at {fit.position:.0f} ± {fit.uncertainty:.0f}, HFR {fit.hfr:.2f} px"
        return PartOutcome(good=True, message=said)
