"""How a night asks for its frames: the parts of ``night:`` that speak of the camera, as values."""

from __future__ import annotations

from talaia.model.base import Shape

__all__ = [
    "FilterCommand",
    "FrameCommand",
    "NightDarks",
    "NightField",
    "NightFlats",
    "RotatorCommand",
    "SettingCommand",
]


class FrameCommand(Shape, frozen=True, kw_only=True):
    """How a frame of one kind is asked of the camera; empty: there is no such argument.

    Attributes:
        command: ``<device>/<command>``; it ends when the frame has been read out.
        args: arguments that are always the same, by name: what kind of frame it is.
        seconds: its argument for the exposure (s); only a bias may have none.
        target: its argument for the target's name.
        binning: its argument for the binning in both axes.
        gain: its argument for the gain.

    """

    command: str
    args: dict[str, float | int | bool | str] = {}
    seconds: str = "seconds"
    target: str = ""
    binning: str = ""
    gain: str = ""


class FilterCommand(Shape, frozen=True, kw_only=True):
    """How a filter is chosen.

    Attributes:
        command: ``<device>/<command>``.
        argument: of the command.
        filters: the argument's value for each filter, by the name that requests call it.
        longer: pictures for focus and centring are exposed so many times as long through a filter
            that lets little through, by its name.

    """

    command: str
    argument: str
    filters: dict[str, float | int | str]
    longer: dict[str, float] = {}

    def exposure_factor(self, name: str) -> float:
        """Give how many times as long pictures for focus and centring are exposed through it."""
        return self.longer.get(name, 1.0)


class SettingCommand(Shape, frozen=True, kw_only=True):
    """How a number of the camera is set before frames, where the frame's command does not take it.

    Attributes:
        command: ``<device>/<command>``.
        arguments: of the command, each of which takes the number: two where it has one an axis.
        reading: address of the signal that says what is set, or empty. It is set when that says
            so, and not asked for where it says so already; without one its command's word counts.
        within: (s).

    """

    command: str
    arguments: tuple[str, ...]
    reading: str = ""
    within: float = 30.0


class NightDarks(Shape, frozen=True, kw_only=True):
    """Dark frames that are taken while the roof is closed and nothing else can be done.

    Attributes:
        command: see `FrameCommand`; one that needs no open roof.
        exposures: so long each (s); a bias is one of no length.
        count: of each in a night.

    """

    command: FrameCommand
    exposures: tuple[float, ...] = (60.0, 300.0)
    count: int = 5


class NightFlats(Shape, frozen=True, kw_only=True):
    """Flats of the twilight sky, which requests ask for.

    They are taken at dusk and at dawn, opposite the Sun, under a roof that may be open: while the
    Sun stands between `NightSun.observing` and `NightSun.closing`. Each is measured, and the next
    is exposed so that its level is right.

    Attributes:
        command: see `FrameCommand`.
        level: median that a flat is to have (counts).
        least: a flat that has less is no flat, and is taken again (counts).
        most: one that has more neither (counts).
        pedestal: median of a frame without light (counts).
        shortest: no flat is exposed for less (s).
        longest: none is exposed for more (s).
        altitude: where the telescope points, away from the Sun (°).
        tries: after so many frames in a row without a right level a block fails.

    """

    command: FrameCommand
    level: float = 20_000.0
    least: float = 10_000.0
    most: float = 35_000.0
    pedestal: float = 0.0
    shortest: float = 1.0
    longest: float = 60.0
    altitude: float = 75.0
    tries: int = 8


class RotatorCommand(Shape, frozen=True, kw_only=True):
    """How the camera is turned, so that a picture's top points where a request wants it.

    Attributes:
        command: ``<device>/<command>``.
        argument: of the command, for the angle (°).
        reading: address of the angle at which it stands (°), or empty. It is there when that says
            so, and not asked for where it says so already; without one its command's word counts.
        zero: angle at which the top of a picture points north (°).
        reverse: the angle grows from north through west: as seen in a mirror.
        within: (s).

    """

    command: str
    argument: str
    reading: str = ""
    zero: float = 0.0
    reverse: bool = False
    within: float = 180.0

    def angle_for(self, position_angle: float) -> float:
        """Give the rotator's angle (°, 0 to 360) for a picture's position angle (°)."""
        turned = -position_angle if self.reverse else position_angle
        return (self.zero + turned) % 360.0


class NightField(Shape, frozen=True, kw_only=True):
    """How much of the sky a picture shows: for framing, and for the panels of a mosaic.

    In degrees it is the chip's size by the focal length, in the same unit, times 57.3: a chip of
    6.9 by 4.6 mm at 2000 mm shows 0.197 by 0.131°.

    Attributes:
        width: of the whole picture (°).
        height: of the whole picture (°).
        position_angle: where its top points, from north through east (°); with a rotator: where
            nobody asks for another.
        rotator: see `RotatorCommand`; none: the camera's angle is fixed.

    """

    width: float
    height: float
    position_angle: float = 0.0
    rotator: RotatorCommand | None = None

    def shows_angle(self, position_angle: float, tolerance: float = 1.0) -> bool:
        """Tell whether a camera that is not turned shows a field at an angle (°).

        A rectangle that is turned by half a turn is the same one.
        """
        off = (position_angle - self.position_angle + 90.0) % 180.0 - 90.0
        return abs(off) <= tolerance
