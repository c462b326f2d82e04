"""How a night asks for its frames: the parts of ``night:`` that speak of the camera, as values."""

from __future__ import annotations

from talaia.model.base import Shape

__all__ = [
    "FilterCommand",
    "FrameCommand",
    "NightDarks",
    "NightFlats",
    "SettingCommand",
]


class FrameCommand(Shape, frozen=True, kw_only=True):
    """How a frame of one kind is asked of the camera; empty: there is no such argument.

    Attributes:
        command: ``<device>/<command>``; it ends when the frame has been read out.
        args: arguments that are always the same, by name: what kind of frame it is.
        seconds: its argument for the exposure (s).
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
