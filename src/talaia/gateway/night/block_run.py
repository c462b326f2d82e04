"""One try at a request: slew, settle, centre, guide, then frame after frame. Pure.

Steps are made one by one as the night goes on, so that a meridian flip comes between two frames
and what was read out is counted as soon as it is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.night.frames.frame_arguments import frame_arguments
from talaia.gateway.night.frames.frame_settings import FrameSettings
from talaia.gateway.night.frames.frame_watch import FrameWatch
from talaia.gateway.night.frames.rotator_steps import turn_steps
from talaia.gateway.night.frames.stepwise_block import StepwiseBlock
from talaia.gateway.night.imaging.guide_steps import GuideSteps, dithered_place
from talaia.gateway.night.night_values import PartRun
from talaia.gateway.night.simple_dispatch import frames_left
from talaia.gateway.night.step_runner import NightStep, StepRunner, StepsState
from talaia.gateway.night.target_place import arcseconds_between, hour_angle_of, place_of_date
from talaia.model.observing.requests import Guiding
from talaia.model.observing.targets import FixedTarget, IcrsTarget, target_name

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.gateway.night.night_values import NightView, StepAnswer
    from talaia.gateway.night.target_place import EquatorialPlace
    from talaia.model.interlocks.enclosure import Place
    from talaia.model.night_section import NightSection, PointCommand
    from talaia.model.observing.requests import Configuration, Request
    from talaia.wire.frames import Scalar

__all__ = ["BlockParts", "BlockRun"]

# Beyond its exposure and readout a frame may take so long: a dome that comes into place first.
FRAME_MARGIN_S = 180.0
# Parts bound themselves; this is for one that does not.
PART_S = 600.0
_SECONDS_IN_HOUR_ANGLE = 3600.0
# What moves among the stars is followed by slews between frames, once it is so far off (″).
MOST_OFF_ARCSEC = 60.0
# A slew to what moves ends where it no longer is; a second, short one brings it there. What a
# mount cannot reach so is exposed as it is, or the block would slew for ever.
SLEWS_BEFORE_FRAME = 2
# What a mount says after a slew comes with its next report.
TRACKING_S = 30.0
# An exposure that is ended needs so long until the next may begin (s).
ABORT_S = 2.0


class BlockParts:
    """Which parts that look at stars there are.

    Attributes:
        solves: fields are centred by what is seen.
        guides: a star is held.
        focus_due: tells whether a focus run is due, by the filter and the time.
        guide_lost: says why the star that was held is not held now; empty while it is.

    """

    def __init__(
        self,
        *,
        solves: bool = False,
        guides: bool = False,
        focus_due: Callable[[str, float], bool] | None = None,
        guide_lost: Callable[[], str] | None = None,
    ) -> None:
        """Take what is there."""
        self.solves, self.guides = solves, guides
        self.focus_due = focus_due if focus_due is not None else lambda _filter, _time: False
        self.guide_lost = guide_lost if guide_lost is not None else str


class BlockRun(StepwiseBlock):
    """See the module."""

    def __init__(
        self,
        *,
        request: Request,
        frames_done: tuple[int, ...],
        night: NightSection,
        place: Place,
        parts: BlockParts,
        next_id: Callable[[], str],
        now: float,
    ) -> None:
        """Begin a try; of ``frames_done`` no frame is taken again."""
        super().__init__(request, frames_done, next_id=next_id, now=now)
        self._night, self._place, self._parts = night, place, parts
        # Where the telescope was sent last, and how often since a frame was taken.
        self._sent: EquatorialPlace | None = None
        self._slews = 0
        self._guiding = GuideSteps(parts, self._part)
        self._settings = FrameSettings(night)
        # On which side of the meridian it points.
        self._east: bool | None = None
        # A frame that was lost is taken again, as often as a step is tried.
        self._watch = FrameWatch(parts.guide_lost)
        self._lost, self._exposing = 0, request.configurations[0]
        # It stands while the sky goes by.
        self._stands = isinstance(request.target, FixedTarget)

    def take_answer(self, answer: StepAnswer) -> None:
        """Take how a command or part ended."""
        if answer.place is not None and self._runner.is_waiting_for(answer.id):
            # Where the mount has to stand for the field to be in the middle.
            self._sent = answer.place
        super().take_answer(answer)

    def _next_steps(self, view: NightView) -> list[NightStep]:
        left = frames_left(self.request, tuple(self.frames_done))
        index = next((i for i, count in enumerate(left) if count), None)
        if index is None:
            return self._guiding.stop_steps()
        configuration = self.request.configurations[index]
        flips = self._flip_due(view, configuration)
        if self._sent is None or flips or self._has_moved(view, configuration):
            return self._point(view, configuration, flips=flips)
        steps = self._settings.steps_for(configuration, self._night.light)
        steps += self._tracking_steps()
        # Stars that go by are neither focused on nor held.
        if not self._stands:
            name = configuration.filter
            if self._parts.focus_due(name, view.time):
                # The filter's step has not been done yet: its name is not that of the one before.
                steps.append(self._part("focusing", "focus", required=False, name=name))
            steps += self._guiding.steps_for(configuration, view.now)
            if offset := self._offset(configuration):
                steps += [*offset, *self._tracking_steps()]
        return [*steps, self._frame(index, configuration)]

    def _tracking_steps(self) -> list[NightStep]:
        """Give what makes sure that the mount follows the sky, or stands, before a frame."""
        night = self._night
        if night.tracking is None or (self._stands and night.point is None):
            return []
        if self._stands:
            return [
                NightStep(
                    words="waiting until it stands",
                    within=TRACKING_S,
                    reached=lambda view: view.tracking is False,
                )
            ]
        return [
            NightStep(
                words="waiting until it tracks",
                command=night.track.command if night.track is not None else "",
                args=night.track.args if night.track is not None else {},
                within=TRACKING_S,
                tries=night.step_tries,
                reached=lambda view: view.tracking is True,
            )
        ]

    def lost_frame(self, view: NightView) -> str:
        """Say why the frame under way is worth nothing: its star, or the sky, is not followed."""
        if not self._runner.takes_frame:
            self._watch.forget_frame()
            return ""
        return self._watch.lost_reason(
            view,
            guided=self._exposing.guiding is Guiding.ON and not self._stands,
            tracked=not self._stands,
        )

    def retake_frame(self, why: str) -> None:
        """Point, guide and expose anew; what is lost again and again fails the block."""
        self._lost += 1
        self._watch.forget_frame()
        if self._lost >= self._night.step_tries:
            super().retake_frame(f"{why} during {self._lost} exposures of a frame")
            return
        # Where it points by now nobody knows.
        self._sent = None
        words = f"beginning the frame again, for {why}"
        self._runner = StepRunner([NightStep(words=words, wait=ABORT_S)], self._next_id)

    def _flip_due(self, view: NightView, configuration: Configuration) -> bool:
        """Tell whether the next frame would end on the other side of the meridian."""
        if not self._night.times.meridian_flip or self._east is not True:
            return False
        where = place_of_date(self.request.target, view.time, self._place)
        if where is None:
            return False
        hours = hour_angle_of(where, self._place, view.time)
        # A mount that tracks beyond the meridian turns over behind what it can still take there.
        limit = self._night.flip_after / _SECONDS_IN_HOUR_ANGLE
        return hours + configuration.exposure / _SECONDS_IN_HOUR_ANGLE >= limit

    def _has_moved(self, view: NightView, configuration: Configuration) -> bool:
        """Tell whether the target has gone from where the telescope was sent."""
        if self._slews >= SLEWS_BEFORE_FRAME or isinstance(self.request.target, IcrsTarget):
            return False
        if self._stands and self._night.point is not None:
            return False
        where = self._aim(view, configuration)
        if where is None or self._sent is None:
            return False
        return arcseconds_between(where, self._sent) > MOST_OFF_ARCSEC

    def _aim(self, view: NightView, configuration: Configuration) -> EquatorialPlace | None:
        """Give where the target stands in the middle of a frame that is taken after a slew."""
        ahead = self._night.times.settle + configuration.exposure / 2.0
        return place_of_date(self.request.target, view.time + ahead, self._place)

    def _point(
        self, view: NightView, configuration: Configuration, *, flips: bool
    ) -> list[NightStep]:
        where = self._aim(view, configuration)
        if where is None:
            self.state, self.why = StepsState.FAILED, "nobody knows where its target stands"
            return []
        steps: list[NightStep] = []
        hours = hour_angle_of(where, self._place, view.time)
        if flips and hours < 0:
            # Until it has passed: a mount flips only then. The field is centred anew behind it.
            wait = -hours * _SECONDS_IN_HOUR_ANGLE
            steps.append(NightStep(words="waiting for the meridian", wait=wait + 1.0))
        steps += self._guiding.stop_steps()
        self._sent, self._east = where, hours < 0 and not flips
        self._slews += 1
        # Before the field is centred: pictures of it are taken through that filter, too.
        steps += self._settings.steps_for(configuration, self._night.light)
        if isinstance(self.request.target, FixedTarget) and self._night.point is not None:
            return [*steps, self._stand_at(self._night.point, self.request.target)]
        # Before the field is centred, for a camera off its axis moves the field as it turns.
        steps += turn_steps(self._night, self.request.target)
        steps.append(self._slew(where, "flipping" if flips else "slewing"))
        if self._parts.solves and isinstance(self.request.target, IcrsTarget):
            steps.append(self._part("centring", "centre", name=configuration.filter))
        return steps

    def _stand_at(self, point: PointCommand, target: FixedTarget) -> NightStep:
        args = {point.altitude: target.altitude, point.azimuth: target.azimuth}
        return self._move(point.command, args, "pointing")

    def _slew(self, where: EquatorialPlace, words: str) -> NightStep:
        slew = self._night.slew
        return self._move(slew.command, {slew.ra: where[0], slew.dec: where[1]}, words)

    def _move(self, command: str, args: Mapping[str, Scalar], words: str) -> NightStep:
        night = self._night
        return NightStep(
            words=words,
            command=command,
            args=args,
            # To the pole and over: 180° of each axis.
            within=180.0 / night.times.slew_rate + night.times.meridian_flip + 120.0,
            tries=night.step_tries,
            wait=night.times.settle,
        )

    def _offset(self, configuration: Configuration) -> list[NightStep]:
        """Dither by the mount, where no guider holds a star."""
        if self._sent is None or not self._guiding.dithers_by_mount(configuration):
            return []
        self._guiding.dither_due = False
        where = dithered_place(self._sent, configuration.dither, sum(self.frames_done))
        return [self._slew(where, "dithering")]

    def _part(
        self, words: str, part: str, *, required: bool = True, name: str = "", dither: float = 0.0
    ) -> NightStep:
        target = self.request.target
        ra, dec = (target.ra, target.dec) if isinstance(target, IcrsTarget) else (0.0, 0.0)
        run = PartRun("", part, PART_S, name or (self._settings.filter or ""), ra, dec, dither)
        # What may be left out is not worth a second try: a focus run takes minutes.
        tries = self._night.step_tries if required else 1
        return NightStep(words=words, part=run, within=PART_S, tries=tries, required=required)

    def _frame(self, index: int, configuration: Configuration) -> NightStep:
        def read_out() -> None:
            self.frames_done[index] += 1
            self._slews = self._lost = 0
            self._guiding.dither_due = True

        self._exposing = configuration
        target = target_name(self.request.target) if self.request.target is not None else ""
        args = frame_arguments(
            self._night.light,
            configuration.exposure,
            target=target,
            binning=configuration.binning,
            gain=configuration.gain,
        )
        number = self.frames_done[index] + 1
        return NightStep(
            words=f"exposing {number} of {configuration.count}",
            command=self._night.light.command,
            args=args,
            is_frame=True,
            within=configuration.exposure + self._night.times.readout + FRAME_MARGIN_S,
            tries=self._night.step_tries,
            on_done=read_out,
        )
