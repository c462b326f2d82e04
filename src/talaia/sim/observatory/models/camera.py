"""A cooled CCD camera behind the telescope. Pure: time is given.

Its pictures are FITS files with a header that says all that is known: where and when, through
what, of what, in which weather. Long, because only the camera knows what stands in it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from talaia.model.units.astronomy import (
    J2000,
    Observer,
    equatorial_to_horizontal,
    julian_day,
    precess_coordinates,
    sun_position,
)
from talaia.sim.observatory.models.fits import Card, fits_file
from talaia.sim.observatory.models.optics import FILTERS, best_focus
from talaia.sim.observatory.models.sky_brightness import moonlight, sky_magnitude
from talaia.sim.observatory.models.sky_picture import Chip, Shot, draw_picture
from talaia.sim.observatory.models.ticket import Ticket

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["FRAMES", "STATES", "CcdCamera", "Picture", "Scene"]

STATES = ("idle", "exposing", "reading")
FRAMES = ("light", "dark", "bias", "flat")
# From the shutter's closing to the picture (s).
READ_S = 1.0
# Of the flat field's lamp through nothing (electrons/s and pixel).
LAMP = 6000.0
BINNINGS = (1, 2, 3, 4)
# The amplifier's settings, in tenths of a decibel.
MOST_GAIN = 300


@dataclass
class Scene:
    """What the camera's server knows of the rest of the observatory.

    Attributes:
        ra: where the mount says that the telescope points (h, of date).
        dec: (°, of date).
        axis: where it really points (h, °, of date); none: as the mount says.
        dome_open: light comes in.
        lamp: that of the flat field burns.
        focus: where the focuser says that it stands (steps); none: there is no focuser.
        mirror: where the mirror really stands (steps).
        tube: temperature of the tube (°C).
        filter_name: in the light; empty for none.
        weather: values by name, for the header.

    """

    place: Observer
    ra: float = 0.0
    dec: float = 0.0
    axis: tuple[float, float] | None = None
    dome_open: bool = False
    lamp: bool = False
    focus: float | None = None
    mirror: float | None = None
    tube: float = 10.0
    filter_name: str = ""
    weather: dict[str, float] = field(default_factory=dict)


@dataclass
class Picture:
    """One exposure, read out.

    Attributes:
        counts: of 16 bits, bottom row first.
        fits: the file.
        name: of the file.

    """

    counts: NDArray[np.uint16]
    fits: bytes
    name: str


@dataclass
class _Begun:
    seconds: float
    frame: str
    target: str
    # s, UTC; negative until the first step, for only that knows the time.
    unix: float
    # As everything stood when it began.
    scene: Scene
    binning: int
    gain: float


class CcdCamera:
    """The camera and its controller.

    Attributes:
        state: one of `STATES`.
        remaining: of the exposure (s).
        celsius: of the chip.
        setpoint: where the cooler holds the chip, while it is on.
        cooling: the cooler is on.
        binning: pixels read as one, along each side.
        gain: of the amplifier (tenths of a decibel).
        newest: the newest picture.

    """

    def __init__(self, scene: Scene, chip: Chip | None = None, ambient: float = 12.0) -> None:
        """Start warm and idle."""
        self.chip = chip or Chip()
        self.scene = scene
        self.state = "idle"
        self.remaining = 0.0
        self.celsius = ambient
        self.setpoint = -10.0
        self.cooling = False
        self.binning = 1
        self.gain = 0.0
        self.newest: Picture | None = None
        self._ambient = ambient
        # Of the exposure under way; an ended one while there is none.
        self._ticket = Ticket.done("")
        # The exposure under way, until it is read out.
        self._begun: _Begun | None = None
        # When the read-out ends (s, UTC), and when time passed last.
        self._read_until = 0.0
        self._stepped_s: float | None = None
        # Pictures so far, for their names.
        self._count = 0

    # ── what may be asked ──

    def start_exposure(self, seconds: float, frame: str = "light", target: str = "") -> Ticket:
        """Begin an exposure (s)."""
        if frame not in FRAMES:
            return Ticket.refused(f"frame {frame!r}: expected one of {', '.join(FRAMES)}")
        # A bias is read without an exposure.
        least = 0.0 if frame == "bias" else 0.04
        if not least <= seconds <= 3600.0:
            return Ticket.refused(f"exposure {seconds:g} s: expected {least:g} to 3600 s")
        if self.state != "idle":
            return Ticket.refused("the camera is exposing; abort first")
        self.state, self.remaining = "exposing", seconds
        # A copy: what changes from here on belongs to the next picture.
        now = Scene(**{**vars(self.scene), "weather": dict(self.scene.weather)})
        self._begun = _Begun(seconds, frame, target, -1.0, now, self.binning, self.gain)
        self._ticket = Ticket()
        return self._ticket

    def abort_exposure(self) -> Ticket:
        """End an exposure without a picture."""
        was = self.state
        self.state, self.remaining, self._begun = "idle", 0.0, None
        self._ticket.end_with("the exposure was aborted", good=False)
        return Ticket.done("the camera was idle" if was == "idle" else "the exposure was aborted")

    def cool_to(self, celsius: float) -> Ticket:
        """Hold the chip at a temperature (°C)."""
        if not -40.0 <= celsius <= 20.0:
            return Ticket.refused(f"temperature {celsius:g} °C: expected -40 to 20 °C")
        self.setpoint, self.cooling = celsius, True
        return Ticket.done(f"the camera is cooled to {celsius:g} °C")

    def switch_cooler(self, on: bool) -> Ticket:  # noqa: FBT001 - a switch, as the service has it
        """Switch the cooler."""
        self.cooling = on
        return Ticket.done(f"the cooler is {'on' if on else 'off'}")

    def set_binning(self, factor: float) -> Ticket:
        """Read so many pixels as one along each side, from the next exposure on."""
        if factor not in BINNINGS:
            return Ticket.refused(f"binning {factor:g}: expected one of 1, 2, 3, 4")
        self.binning = int(factor)
        return Ticket.done(f"the binning is {self.binning}")

    def set_gain(self, gain: float) -> Ticket:
        """Set the amplifier (tenths of a decibel), from the next exposure on."""
        if not 0 <= gain <= MOST_GAIN:
            return Ticket.refused(f"gain {gain:g}: expected 0 to {MOST_GAIN}")
        self.gain = gain
        return Ticket.done(f"the gain is {gain:g}")

    # ── time ──

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass. A picture that is read out stands in `newest`."""
        self._ambient = self.scene.weather.get("temperature", self._ambient)
        # A Peltier stage reaches some 35 °C below the air, with a time constant of a minute.
        goal = max(self.setpoint, self._ambient - 35.0) if self.cooling else self._ambient
        self.celsius += (goal - self.celsius) * (1.0 - math.exp(-seconds / 60.0))
        before, self._stepped_s = self._stepped_s, unix_s
        begun = self._begun
        if begun is None:
            return
        # It began right behind the step before this one. Of a site that lives faster than its
        # clock, ``seconds`` are not the clock's.
        if begun.unix < 0.0:
            begun.unix = unix_s - seconds if before is None else before
        if self.state == "exposing":
            self.remaining = max(0.0, self.remaining - seconds)
            if self.remaining <= 0.0:
                self.state, self.remaining = "reading", 0.0
                self._read_until = unix_s + READ_S
        elif unix_s >= self._read_until:
            self._count += 1
            self.newest = self._read_out(begun)
            self.state, self._begun = "idle", None
            self._ticket.end_with(f"{self.newest.name} is taken", good=True)

    def _read_out(self, begun: _Begun) -> Picture:
        jd = julian_day(begun.unix)
        shot = self._shot_of(begun, jd)
        counts = draw_picture(shot, self.chip)
        when = datetime.fromtimestamp(begun.unix, UTC)
        name = f"{when:%Y%m%dT%H%M%S}-{begun.frame}-{self._count:04d}.fits"
        return Picture(counts, fits_file(counts, self._fits_cards(begun, jd)), name)

    def _shot_of(self, begun: _Begun, jd: float) -> Shot:
        scene, place = begun.scene, begun.scene.place
        axis = scene.axis or (scene.ra, scene.dec)
        ra, dec = precess_coordinates(*axis, jd, J2000)
        # Where it points when the shutter closes: what drifted meanwhile is a line.
        after = self.scene.axis or axis
        east = ((after[0] - axis[0] + 12.0) % 24.0 - 12.0) * 15.0 * math.cos(math.radians(axis[1]))
        at = equatorial_to_horizontal(*axis, place, jd)
        sun_alt = equatorial_to_horizontal(*sun_position(jd), place, jd).alt
        clouds = scene.weather.get("clouds", 0.0)
        glass = next((one for one in FILTERS if one.name == scene.filter_name), None)
        opened = begun.frame in ("light", "flat")
        return Shot(
            ra=ra * 15.0,
            dec=dec,
            seconds=begun.seconds,
            light=opened and scene.dome_open,
            celsius=self.celsius,
            sky=sky_magnitude(at, sun_alt, moonlight(place, begun.unix), clouds),
            lamp=_lamp_light(scene, glass.sky if glass else 1.0) if opened else 0.0,
            clear=max(0.0, 1.0 - clouds / 100.0)
            * _air_clear(at.alt)
            * (glass.stars if glass else 1),
            sky_clear=glass.sky if glass else 1.0,
            filter_name=scene.filter_name,
            # Air masses smear; 2.2 seconds of arc overhead.
            seeing=2.2 * _airmass(at.alt) ** 0.6,
            defocus=_steps_off(scene),
            drift=(east * 3600.0, (after[1] - axis[1]) * 3600.0),
            binning=begun.binning,
            gain=10 ** (begun.gain / 200.0),
            # Other noise in each picture, and the same again in each run.
            seed=self._count,
        )

    def _fits_cards(self, begun: _Begun, jd: float) -> list[Card]:
        chip, scene = self.chip, begun.scene
        at = equatorial_to_horizontal(scene.ra, scene.dec, scene.place, jd)
        when = datetime.fromtimestamp(begun.unix, UTC)
        ra, dec = precess_coordinates(scene.ra, scene.dec, jd, J2000)
        cards: list[Card] = [
            ("DATE-OBS", f"{when:%Y-%m-%dT%H:%M:%S}.{when.microsecond // 1000:03d}", "begin, UTC"),
            ("TIMESYS", "UTC", "time scale"),
            ("MJD-OBS", jd - 2400000.5, "modified Julian date of the begin"),
            ("EXPTIME", begun.seconds, "[s] exposure"),
            ("IMAGETYP", begun.frame.capitalize(), "kind of frame"),
            ("OBJECT", begun.target or "unknown", "target"),
            ("TELESCOP", "Simulated Meade LX200GPS", "telescope"),
            ("INSTRUME", "Simulated SBIG ST-7", "camera"),
            ("OBSERVAT", "Talaia simulated observatory", "observatory"),
            ("SITELAT", scene.place.latitude, "[deg] north"),
            ("SITELONG", scene.place.longitude, "[deg] east"),
            ("SITEELEV", scene.place.elevation, "[m]"),
            ("FOCALLEN", chip.focal_mm, "[mm] focal length"),
            ("XPIXSZ", chip.pixel_um * begun.binning, "[um] pixel as binned"),
            ("YPIXSZ", chip.pixel_um * begun.binning, "[um] pixel as binned"),
            ("SCALE", chip.scale * begun.binning, "[arcsec/px]"),
            ("XBINNING", begun.binning, "binning"),
            ("YBINNING", begun.binning, "binning"),
            ("GAIN", begun.gain, "[0.1 dB] amplifier"),
            ("EGAIN", chip.gain / 10 ** (begun.gain / 200.0), "[electron/adu]"),
            ("FILTER", scene.filter_name or "none", "filter"),
            ("RDNOISE", chip.read, "[electron]"),
            ("CCD-TEMP", round(self.celsius, 2), "[degC] chip"),
            ("SET-TEMP", self.setpoint, "[degC] set point"),
            # No WCS: the mount does not know where it points to a few minutes of arc.
            ("RA", ra * 15.0, "[deg] J2000, as the mount says"),
            ("DEC", dec, "[deg] J2000, as the mount says"),
            ("EQUINOX", 2000.0, "[yr]"),
            ("OBJCTRA", _sexagesimal_text(ra), "[h m s] J2000"),
            ("OBJCTDEC", _sexagesimal_text(dec, signed=True), "[d m s] J2000"),
            ("OBJCTALT", round(at.alt, 4), "[deg] altitude"),
            ("OBJCTAZ", round(at.az, 4), "[deg] azimuth"),
            ("DOMEOPEN", scene.dome_open, "light came in"),
        ]
        if scene.focus is not None:
            cards.append(("FOCUSPOS", round(scene.focus), "[step] focuser"))
            cards.append(("FOCTEMP", round(scene.tube, 2), "[degC] tube"))
        if at.alt > 0:
            cards.append(("AIRMASS", round(_airmass(at.alt), 4), "Pickering"))
        for key, name, comment in (
            ("AMBTEMP", "temperature", "[degC] air"),
            ("HUMIDITY", "humidity", "[%] relative"),
            ("DEWPOINT", "dew_point", "[degC]"),
            ("WINDSPD", "wind", "[km/h]"),
            ("CLOUDCVR", "clouds", "[%]"),
            ("AOCBAROM", "pressure", "[hPa]"),
        ):
            if name in scene.weather:
                cards.append((key, round(scene.weather[name], 2), comment))
        cards.append(("SWCREATE", "Talaia", "written by"))
        return cards


def _airmass(alt: float) -> float:
    # Pickering (2002), good down to the horizon.
    angle = max(0.0, alt) + 244.0 / (165.0 + 47.0 * max(0.0, alt) ** 1.1)
    return 1.0 / math.sin(math.radians(angle))


def _air_clear(alt: float) -> float:
    # A fifth of a magnitude is lost in each air mass; `Chip.zero` has the one overhead.
    return float(10 ** (-0.4 * 0.2 * (_airmass(alt) - 1.0)))


def _lamp_light(scene: Scene, filter_sky: float) -> float:
    # It shines on the inside of a closed dome.
    return LAMP * filter_sky if scene.lamp and not scene.dome_open else 0.0


def _steps_off(scene: Scene) -> float:
    # Without a focuser somebody focused by hand.
    if scene.mirror is None:
        return 0.0
    return scene.mirror - best_focus(scene.tube, scene.filter_name)


def _sexagesimal_text(value: float, *, signed: bool = False) -> str:
    # Rounded before it is divided, so that no seconds are shown as 60.0.
    tenths = round(abs(value) * 36000)
    sign = ("-" if value < 0 else "+") if signed else ""
    hours, rest = divmod(tenths, 36000)
    return f"{sign}{hours:02d} {rest // 600:02d} {rest % 600 / 10:04.1f}"
