"""How a site observes by itself: the description's ``night:``, as values.

What keeps the roof safe is not here: interlocks and enclosures say when it may open, and the night
asks for its commands as a person does. Long, because every key of the section stands here.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING

from talaia.model.base import Shape
from talaia.model.derivation.source import DerivedSource
from talaia.model.detection import DetectionSource
from talaia.model.interlocks.enclosure import Sighting  # noqa: TC001 - msgspec reads it
from talaia.model.interlocks.interlock import Step  # noqa: TC001 - msgspec reads it
from talaia.model.night_frames import (  # noqa: TC001 - msgspec reads them
    FilterCommand,
    FrameCommand,
    NightDarks,
    NightField,
    NightFlats,
    RotatorCommand,
    SettingCommand,
)
from talaia.model.observing.plan import Instrument, PauseRules
from talaia.model.observing.requests import ImageType
from talaia.model.roles import SignalRole

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.site import Device

__all__ = [
    "NightCentring",
    "NightFocuser",
    "NightGuider",
    "NightLinkLoss",
    "NightSection",
    "NightSun",
    "PointCommand",
    "SlewCommand",
]


class NightLinkLoss(StrEnum):
    """What an armed night does while the hub is away.

    ``continue``: it goes on by its own rules, and the ``link_loss`` of its devices waits until it
    is disarmed. ``park``: their ``link_loss`` counts as ever, and ends the night.
    """

    CONTINUE = "continue"
    PARK = "park"


class SlewCommand(Shape, frozen=True, kw_only=True):
    """How the telescope is sent to a place among the stars.

    Attributes:
        command: ``<device>/<command>``.
        ra: its argument for the right ascension of date (h).
        dec: its argument for the declination of date (°).

    """

    command: str
    ra: str = "ra"
    dec: str = "dec"


class PointCommand(Shape, frozen=True, kw_only=True):
    """How the telescope is sent to a place above the horizon, to stand there.

    Attributes:
        command: ``<device>/<command>``.
        altitude: its argument for the altitude (°).
        azimuth: its argument for the azimuth, from the north by the east (°).

    """

    command: str
    altitude: str = "alt"
    azimuth: str = "az"


class NightFocuser(Shape, frozen=True, kw_only=True):
    """How the night focuses: on the field itself, for another filter, and again after a while.

    Attributes:
        command: ``<device>/<command>``; it ends when the focuser stands.
        argument: of the command, for the position (steps).
        position: address of where it stands (steps).
        temperature: address of the tube's temperature (°C), or empty.
        every: again after so long (s).
        degrees: again after the tube has changed by so much (°C).
        seconds: each picture is exposed so long (s).

    """

    command: str
    argument: str = "position"
    position: str
    temperature: str = ""
    every: float = 7200.0
    degrees: float = 1.5
    seconds: float = 4.0


class NightCentring(Shape, frozen=True, kw_only=True):
    """How fields are centred: by pictures that are solved, and small slews.

    Attributes:
        seconds: each picture is exposed so long (s).

    """

    seconds: float = 5.0


class NightGuider(Shape, frozen=True, kw_only=True):
    """Where PHD2 listens, which guides.

    Attributes:
        host: its address, as the gateway reaches it.
        port: of its event server.

    """

    host: str = "127.0.0.1"
    port: int = 4400


class NightSun(Shape, frozen=True, kw_only=True):
    """Where the Sun has to stand (its altitude, °).

    Attributes:
        opening: the roof opens at or below this.
        observing: targets are observed at or below this; a request may ask for less.
        closing: above this the telescope parks and the roof closes, whatever is under way.
        calibrating: frames that need no sky are taken for requests, under a closed roof, at or
            below this.

    """

    opening: float = -9.0
    observing: float = -12.0
    closing: float = -8.0
    calibrating: float = 0.0


class NightSection(Shape, frozen=True, kw_only=True):
    """How a site observes by itself, once somebody has armed it.

    Attributes:
        enclosure: the roof, by its name among the enclosures; how it closes and how the telescope
            parks stands there.
        opened: the roof is open when this says so.
        open: opens the roof.
        unpark: gets the telescope ready, after the roof is open.
        slew: sends it to a target; see `SlewCommand`.
        point: sends it to a fixed direction, where it stands; see `PointCommand`. None: fixed
            directions are gone back to between frames, by ``slew``.
        tracking: it follows the sky when this says so. No frame of what is among the stars begins
            before, and one during which it ends is taken again; none: nobody looks.
        track: makes it follow the sky where it does not after a slew; none: it is waited for.
        flip_after: a mount that turns over at the meridian (``times.meridian_flip``) still tracks
            so long past it (s): frames that end by then come before the flip.
        light: takes a frame of a target; see `FrameCommand`.
        darks: see `NightDarks`; none: it takes none, and requests of them are refused.
        bias: takes a frame of no length for a request; none: such requests are refused.
        flats: see `NightFlats`; none: requests of them are refused.
        filter: see `FilterCommand`; none: there is one filter, or it is changed by hand.
        binning: see `SettingCommand`; none: as the frames' commands take it, or not at all.
        gain: see `SettingCommand`; none: as the frames' commands take it, or not at all.
        field: see `NightField`; none: nobody knows how much of the sky a picture shows.
        focuser: see `NightFocuser`; none: nobody focuses.
        centring: see `NightCentring`; none: fields are where the slew ends.
        guider: see `NightGuider`; none: nobody guides.
        start: done before the roof opens. What stands behind the last that is ``required`` gets
            ready while it opens, before anything is observed: the cooler.
        end: done after the roof has closed in the morning: the cooler off.
        clouds: address of the cloud cover (%), or empty.
        seeing: address of the seeing (FWHM, ″), or empty; then it is that of the last field that
            was centred, for an hour.
        sun: see `NightSun`.
        times: how long the telescope takes; see `Instrument`.
        step_tries: a step of a block that fails is tried so often in all.
        failure_limit: so many different targets that fail one after the other are a fault of a
            device: it parks, closes and calls somebody.
        hand_over: after a person took a device out of its hands it waits so long (s) from the end
            of what they did, and then goes on.
        link_loss: see `NightLinkLoss`.

    """

    enclosure: str
    opened: Sighting
    open: Step
    unpark: Step
    slew: SlewCommand
    light: FrameCommand
    point: PointCommand | None = None
    tracking: Sighting | None = None
    track: Step | None = None
    flip_after: float = 0.0
    darks: NightDarks | None = None
    bias: FrameCommand | None = None
    flats: NightFlats | None = None
    filter: FilterCommand | None = None
    binning: SettingCommand | None = None
    gain: SettingCommand | None = None
    field: NightField | None = None
    focuser: NightFocuser | None = None
    centring: NightCentring | None = None
    guider: NightGuider | None = None
    start: tuple[Step, ...] = ()
    end: tuple[Step, ...] = ()
    clouds: str = ""
    seeing: str = ""
    sun: NightSun = NightSun()
    times: Instrument = Instrument()
    step_tries: int = 2
    failure_limit: int = 3
    hand_over: float = 300.0
    link_loss: NightLinkLoss = NightLinkLoss.CONTINUE

    def steps(self) -> dict[str, Step]:
        """Give every step with its place in the section."""
        named = {"open": self.open, "unpark": self.unpark}
        if self.track is not None:
            named["track"] = self.track
        named |= {f"start[{index}]": step for index, step in enumerate(self.start)}
        return named | {f"end[{index}]": step for index, step in enumerate(self.end)}

    @property
    def pauses(self) -> PauseRules:
        """What a plan counts with between exposures, beside `times`."""
        times, focuser = self.times, self.focuser
        # The field is looked for anew behind the meridian.
        flip = times.meridian_flip + times.settle + times.acquire if times.meridian_flip else 0.0
        return PauseRules(
            flip=flip,
            flip_after=self.flip_after,
            focus=times.focus_run if focuser is not None else 0.0,
            focus_every=focuser.every if focuser is not None else 7200.0,
        )

    @property
    def rotator(self) -> RotatorCommand | None:
        """What turns the camera; none: its angle is fixed."""
        return self.field.rotator if self.field is not None else None

    def frame_for(self, kind: ImageType) -> FrameCommand | None:
        """Give what takes a frame of a kind; none: nothing does."""
        match kind:
            case ImageType.LIGHT:
                return self.light
            case ImageType.DARK:
                return self.darks.command if self.darks is not None else None
            case ImageType.BIAS:
                return self.bias
            case ImageType.SKY_FLAT:
                return self.flats.command if self.flats is not None else None

    def angles(self, devices: Mapping[str, Device]) -> tuple[str, str]:
        """Name the signals that say at which altitude and azimuth the telescope points.

        By their roles, at the device that is unparked; empty where none has the role. What is
        worked out or seen by a camera is left out: it is no sensor's word, and not at hand.
        """
        name = self.unpark.command.partition("/")[0]
        signals = devices[name].signals.items() if name in devices else ()
        by_role = {
            one.role: f"{name}/{key}"
            for key, one in signals
            if not isinstance(one.source, DerivedSource | DetectionSource)
        }
        wanted = (SignalRole.TELESCOPE_ALTITUDE, SignalRole.TELESCOPE_AZIMUTH)
        altitude, azimuth = (by_role.get(role, "") for role in wanted)
        return altitude, azimuth

    def readings(self, devices: Mapping[str, Device]) -> frozenset[str]:
        """Name every signal that the night goes by beside those of its enclosure."""
        named = [self.opened.signal, self.clouds, self.seeing]
        if self.tracking is not None:
            named.append(self.tracking.signal)
        if self.focuser is not None:
            named += [self.focuser.position, self.focuser.temperature]
        settings = (self.binning, self.gain, self.rotator)
        named += [rule.reading for rule in settings if rule is not None]
        named += self.angles(devices)
        return frozenset(address for address in named if address)

    def commands(self) -> frozenset[str]:
        """Name every command that the night gives beside those of its enclosure."""
        more = [self.slew.command, self.light.command]
        if self.point is not None:
            more.append(self.point.command)
        if self.darks is not None:
            more.append(self.darks.command.command)
        if self.bias is not None:
            more.append(self.bias.command)
        if self.flats is not None:
            more.append(self.flats.command.command)
        if self.filter is not None:
            more.append(self.filter.command)
        if self.focuser is not None:
            more.append(self.focuser.command)
        settings = (self.binning, self.gain, self.rotator)
        more += [rule.command for rule in settings if rule is not None]
        return frozenset([*(step.command for step in self.steps().values()), *more])
