"""A cooled CCD camera behind the telescope. Pure: time is given.

Its pictures are FITS files with a header that says all that is known: where and when, through
what, of what, in which weather.
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
from talaia.sim.observatory.models.stars import Chip, Shot, draw_picture
from talaia.sim.observatory.models.ticket import Ticket

if TYPE_CHECKING:
    from array import array

__all__ = ["FRAMES", "STATES", "CcdCamera", "Picture", "Scene"]

STATES = ("idle", "exposing", "reading")
FRAMES = ("light", "dark", "bias", "flat")
# From the shutter's closing to the picture (s).
READ_S = 1.0


@dataclass
class Scene:
    """What the camera's server knows of the rest of the observatory.

    Attributes:
        ra: where the telescope points (h, of date).
        dec: (°, of date).
        dome_open: light comes in.
        weather: values by name, for the header.

    """

    place: Observer
    ra: float = 0.0
    dec: float = 0.0
    dome_open: bool = False
    weather: dict[str, float] = field(default_factory=dict)


@dataclass
class Picture:
    """One exposure, read out.

    Attributes:
        rows: counts, bottom row first.
        fits: the file.
        name: of the file.

    """

    rows: list[array[int]]
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


class CcdCamera:
    """The camera and its controller.

    Attributes:
        state: one of `STATES`.
        remaining: of the exposure (s).
        celsius: of the chip.
        setpoint: where the cooler holds the chip, while it is on.
        cooling: the cooler is on.
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
        self.newest: Picture | None = None
        self._ambient = ambient
        # Of the exposure under way; an ended one while there is none.
        self._ticket = Ticket.done("")
        # The exposure under way, until it is read out.
        self._begun: _Begun | None = None
        # When the read-out ends (s, UTC).
        self._read_until = 0.0
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
        self._begun = _Begun(seconds, frame, target, -1.0, now)
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

    # ── time ──

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass. A picture that is read out stands in `newest`."""
        self._ambient = self.scene.weather.get("temperature", self._ambient)
        # A Peltier stage reaches some 35 °C below the air, with a time constant of a minute.
        goal = max(self.setpoint, self._ambient - 35.0) if self.cooling else self._ambient
        self.celsius += (goal - self.celsius) * (1.0 - math.exp(-seconds / 60.0))
        begun = self._begun
        if begun is None:
            return
        # It began right behind the step before this one.
        if begun.unix < 0.0:
            begun.unix = unix_s - seconds
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
        scene, place = begun.scene, begun.scene.place
        jd = julian_day(begun.unix)
        ra, dec = precess_coordinates(scene.ra, scene.dec, jd, J2000)
        sun_alt = equatorial_to_horizontal(*sun_position(jd), place, jd).alt
        # About a factor of 2.5 for each degree of twilight; by day it is kept at what a narrow
        # filter lets through, or nobody would ever see a star in a demo that is shown by day.
        sky = 2.0 * min(30.0, 2.5 ** max(0.0, sun_alt + 15.0))
        clouds = scene.weather.get("clouds", 0.0)
        shot = Shot(
            ra=ra * 15.0,
            dec=dec,
            seconds=begun.seconds,
            light=begun.frame in ("light", "flat") and scene.dome_open,
            celsius=self.celsius,
            sky=sky,
            dimmed=max(0.0, 1.0 - clouds / 100.0),
            # Other noise in each picture, and the same again in each run.
            seed=self._count,
        )
        rows = draw_picture(shot, self.chip)
        when = datetime.fromtimestamp(begun.unix, UTC)
        name = f"{when:%Y%m%dT%H%M%S}-{begun.frame}-{self._count:04d}.fits"
        return Picture(rows, fits_file(rows, self._fits_cards(begun, shot, jd)), name)

    def _fits_cards(self, begun: _Begun, shot: Shot, jd: float) -> list[Card]:
        chip, scene = self.chip, begun.scene
        at = equatorial_to_horizontal(scene.ra, scene.dec, scene.place, jd)
        when = datetime.fromtimestamp(begun.unix, UTC)
        scale = chip.scale / 3600.0
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
            ("XPIXSZ", chip.pixel_um, "[um] pixel"),
            ("YPIXSZ", chip.pixel_um, "[um] pixel"),
            ("XBINNING", 1, "binning"),
            ("YBINNING", 1, "binning"),
            ("EGAIN", chip.gain, "[electron/adu]"),
            ("RDNOISE", chip.read, "[electron]"),
            ("CCD-TEMP", round(self.celsius, 2), "[degC] chip"),
            ("SET-TEMP", self.setpoint, "[degC] set point"),
            ("OBJCTRA", _sexagesimal_text(shot.ra / 15.0), "[h m s] J2000"),
            ("OBJCTDEC", _sexagesimal_text(shot.dec, signed=True), "[d m s] J2000"),
            ("OBJCTALT", round(at.alt, 4), "[deg] altitude"),
            ("OBJCTAZ", round(at.az, 4), "[deg] azimuth"),
            ("DOMEOPEN", scene.dome_open, "light came in"),
        ]
        if at.alt > 0:
            # Pickering (2002), good down to the horizon.
            angle = at.alt + 244.0 / (165.0 + 47.0 * at.alt**1.1)
            cards.append(("AIRMASS", round(1 / math.sin(math.radians(angle)), 4), "Pickering"))
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
        cards += [
            ("RADESYS", "FK5", "frame of the coordinates"),
            ("EQUINOX", 2000.0, "[yr]"),
            ("CTYPE1", "RA---TAN", "estimate from the mount"),
            ("CTYPE2", "DEC--TAN", "estimate from the mount"),
            ("CUNIT1", "deg", "unit"),
            ("CUNIT2", "deg", "unit"),
            ("CRVAL1", shot.ra, "[deg] at the reference pixel"),
            ("CRVAL2", shot.dec, "[deg] at the reference pixel"),
            # FITS counts pixels from 1, at their centres.
            ("CRPIX1", (chip.width + 1) / 2, "reference pixel"),
            ("CRPIX2", (chip.height + 1) / 2, "reference pixel"),
            # East is to the left: right ascension grows as x falls.
            ("CD1_1", -scale, "[deg/px]"),
            ("CD1_2", 0.0, "[deg/px]"),
            ("CD2_1", 0.0, "[deg/px]"),
            ("CD2_2", scale, "[deg/px]"),
            ("SWCREATE", "Talaia", "written by"),
        ]
        return cards


def _sexagesimal_text(value: float, *, signed: bool = False) -> str:
    # Rounded before it is divided, so that no seconds are shown as 60.0.
    tenths = round(abs(value) * 36000)
    sign = ("-" if value < 0 else "+") if signed else ""
    hours, rest = divmod(tenths, 36000)
    return f"{sign}{hours:02d} {rest // 600:02d} {rest % 600 / 10:04.1f}"
