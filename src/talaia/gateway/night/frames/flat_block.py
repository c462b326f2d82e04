"""One try at a request of twilight flats: opposite the Sun, each exposed by the one before. Pure.

The sky darkens or brightens by a tenth in half a minute. Each flat is measured; one whose level is
not right counts for nothing, and the next is exposed so that its level is.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.gateway.night.frames.frame_arguments import frame_arguments
from talaia.gateway.night.frames.frame_settings import FrameSettings
from talaia.gateway.night.frames.stepwise_block import StepwiseBlock
from talaia.gateway.night.imaging.guide_steps import dithered_place
from talaia.gateway.night.simple_dispatch import frames_left
from talaia.gateway.night.step_runner import NightStep, StepsState
from talaia.gateway.night.target_place import sun_altitude
from talaia.model.units import astronomy

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.night.night_values import NightView, StepAnswer
    from talaia.gateway.night.target_place import EquatorialPlace
    from talaia.model.interlocks.enclosure import Place
    from talaia.model.night_frames import NightFlats
    from talaia.model.night_section import NightSection
    from talaia.model.observing.requests import Configuration, Request

__all__ = ["FlatBlock", "next_exposure"]

# Between frames, so that no star falls twice on the same pixels (″).
OFFSET_ARCSEC = 120.0
# While the sky is too bright or too dark, and is becoming better: it changes by about 15 % a
# minute, and is looked at within ten minutes at the latest (s).
SHORTEST_WAIT_S, LONGEST_WAIT_S = 20.0, 600.0
CHANGE_EACH_MINUTE = 1.15
# From frame to frame an exposure changes by this at the most: a saturated one says only *too much*.
MOST_CHANGE = 8.0
# Of the most that counts: from here on the chip may be full.
_SATURATED = 0.98
MARGIN_S = 60.0


def next_exposure(flats: NightFlats, exposure: float, level: float) -> float:
    """Give the exposure that makes the level right, by that of the last frame (s); unbounded."""
    light = max(level - flats.pedestal, 1.0)
    factor = (flats.level - flats.pedestal) / light
    if level >= flats.most * _SATURATED:
        # More than that may not have been counted.
        factor = min(factor, 0.5)
    return exposure * min(MOST_CHANGE, max(1.0 / MOST_CHANGE, factor))


class FlatBlock(StepwiseBlock):
    """See the module."""

    def __init__(
        self,
        request: Request,
        frames_done: tuple[int, ...],
        *,
        night: NightSection,
        flats: NightFlats,
        place: Place,
        next_id: Callable[[], str],
        now: float,
    ) -> None:
        """Begin a try; of ``frames_done`` no frame is taken again."""
        super().__init__(request, frames_done, next_id=next_id, now=now)
        self._night, self._flats, self._place = night, flats, place
        self._settings = FrameSettings(night)
        # Where the first frame of this try pointed, and how many frames it has taken.
        self._middle: EquatorialPlace | None = None
        self._taken = 0
        # Of each configuration: what is exposed next (s), and frames in a row of no right level.
        self._exposures: dict[int, float] = {}
        self._wrong: dict[int, int] = {}
        # Of the frame that has just ended (counts); none: nobody measured it.
        self._level: float | None = None

    def take_answer(self, answer: StepAnswer) -> None:
        """Take how a command ended, and a frame's level."""
        if self._runner.is_waiting_for(answer.id):
            self._level = answer.level
        super().take_answer(answer)

    def _next_steps(self, view: NightView) -> list[NightStep]:
        left = frames_left(self.request, tuple(self.frames_done))
        index = next((i for i, count in enumerate(left) if count), None)
        if index is None:
            return []
        configuration, flats = self.request.configurations[index], self._flats
        wanted = self._exposures.get(index, configuration.exposure or flats.shortest)
        now, then = (sun_altitude(self._place, view.time + after) for after in (0.0, 60.0))
        # A quarter beyond its bounds a frame is still of use.
        if index in self._exposures and not (
            flats.shortest / 1.25 <= wanted <= flats.longest * 1.25
        ):
            return self._wait_for_light(index, wanted, up=then > now)
        exposure = min(max(wanted, flats.shortest), flats.longest)
        steps = self._settings.steps_for(configuration, flats.command)
        return [*steps, self._slew(view), self._frame(index, configuration, exposure)]

    def _wait_for_light(self, index: int, wanted: float, *, up: bool) -> list[NightStep]:
        """Wait until the sky is about right, or give up where it only gets worse."""
        too_bright = wanted < self._flats.shortest
        bound = self._flats.shortest if too_bright else self._flats.longest
        words = "too bright" if too_bright else "too dark"
        if too_bright is up:
            self.spoiled = f"the sky is {words} for more flats"
            self.state = StepsState.REFUSED
            self.why = self.spoiled
            return []

        def look_again() -> None:
            # As if it had become right: the next frame tells.
            self._exposures[index] = bound

        minutes = abs(math.log(wanted / bound)) / math.log(CHANGE_EACH_MINUTE)
        wait = min(LONGEST_WAIT_S, max(SHORTEST_WAIT_S, 60.0 * minutes))
        return [NightStep(words=f"waiting: {words} for flats", wait=wait, on_done=look_again)]

    def _slew(self, view: NightView) -> NightStep:
        night, slew = self._night, self._night.slew
        if self._middle is None:
            self._middle = flat_field_place(self._place, view.time, self._flats.altitude)
        where = dithered_place(self._middle, OFFSET_ARCSEC, self._taken)
        return NightStep(
            words="slewing away from the Sun" if not self._taken else "moving off the stars",
            command=slew.command,
            args={slew.ra: where[0], slew.dec: where[1]},
            within=180.0 / night.times.slew_rate + night.times.meridian_flip + 120.0,
            tries=night.step_tries,
            wait=night.times.settle,
        )

    def _frame(self, index: int, configuration: Configuration, exposure: float) -> NightStep:
        self._level = None

        def read_out() -> None:
            self._taken += 1
            self._judge_level(index, exposure)

        args = frame_arguments(
            self._flats.command,
            exposure,
            target="flat",
            binning=configuration.binning,
            gain=configuration.gain,
        )
        number = self.frames_done[index] + 1
        name = f" in {configuration.filter}" if configuration.filter else ""
        return NightStep(
            words=f"flat {number} of {configuration.count}{name}, {exposure:.3g} s",
            command=self._flats.command.command,
            args=args,
            is_frame=True,
            wants_level=True,
            within=exposure + self._night.times.readout + MARGIN_S,
            tries=self._night.step_tries,
            on_done=read_out,
        )

    def _judge_level(self, index: int, exposure: float) -> None:
        flats, level = self._flats, self._level
        if level is None:
            self.state, self.why = StepsState.FAILED, "nobody could measure the flat's level"
            return
        self._exposures[index] = next_exposure(flats, exposure, level)
        if flats.least <= level <= flats.most:
            self.frames_done[index] += 1
            self._wrong[index] = 0
            return
        if exposure in {flats.shortest, flats.longest}:
            # It could not be exposed better: the light of the sky is waited for, or given up.
            return
        self._wrong[index] = self._wrong.get(index, 0) + 1
        if self._wrong[index] >= flats.tries:
            self.state = StepsState.FAILED
            self.why = (
                f"{flats.tries} flats and none of a right level: the last had {level:.0f} counts"
                f" after {exposure:.3g} s"
            )


def flat_field_place(place: Place, time: float, altitude: float) -> EquatorialPlace:
    """Give where the sky is most even: opposite the Sun, at an altitude (°)."""
    here = astronomy.Observer(place.latitude, place.longitude, place.elevation)
    jd = astronomy.julian_day(time)
    sun = astronomy.equatorial_to_horizontal(*astronomy.sun_position(jd), here, jd)
    away = (sun.az + 180.0) % 360.0
    return astronomy.horizontal_to_equatorial(altitude, away, here, jd)
