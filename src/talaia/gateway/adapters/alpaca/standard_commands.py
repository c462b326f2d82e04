"""What can be asked of each type of ASCOM device, as rows: methods with limits and roles. Pure."""

from __future__ import annotations

from typing import NamedTuple

from talaia.model.roles import CommandRole
from talaia.model.site import ArgumentType

__all__ = ["STANDARD_COMMANDS", "ArgumentRow", "StandardMethod"]


class ArgumentRow(NamedTuple):
    """One argument.

    Attributes:
        id: its word in the description.
        field: the method's parameter, or ``binx/BinX`` for another method that is called before.
        low: its least value; or the property that has it, ``-maxstep`` with the other sign.
        high: its greatest value, likewise; of a list, its last index.
        default: of a number, the property that has it, too.
        needs: the property that must be there; empty where it always is.

    """

    id: str
    field: str
    name: str
    unit: str = ""
    low: float | str | None = None
    high: float | str | None = None
    type: ArgumentType = ArgumentType.NUMBER
    default: float | int | bool | str | None = None
    needs: str = ""


class StandardMethod(NamedTuple):
    """One method.

    Attributes:
        method: of the device.
        id: its word in the description.
        needs: the property that must be true (``canpark``), or merely there where it is no truth;
            empty where every device has the method.
        timeout: see `Command.timeout`.

    """

    method: str
    id: str
    name: str
    needs: str = ""
    role: CommandRole = CommandRole.AUTO
    fixed: tuple[tuple[str, float | int | bool | str], ...] = ()
    arguments: tuple[ArgumentRow, ...] = ()
    timeout: float = 30.0
    confirm: bool = False
    description: str = ""


_Role = CommandRole
_EQUATORIAL = (
    ArgumentRow("ra", "RightAscension", "Right ascension", "h", 0.0, 24.0),
    ArgumentRow("dec", "Declination", "Declination", "°", -90.0, 90.0),
)
_HORIZONTAL = (
    ArgumentRow("azimuth", "Azimuth", "Azimuth", "°", 0.0, 360.0),
    ArgumentRow("altitude", "Altitude", "Altitude", "°", 0.0, 90.0),
)
_ON = (("Tracking", True),)


def _frame(
    word: str, name: str, *, light: bool, kind: str, arguments: tuple[ArgumentRow, ...]
) -> StandardMethod:
    """Give what takes a frame of a kind: shutter open or closed, and its name in the header."""
    return StandardMethod(
        "startexposure",
        word,
        name,
        "",
        _Role.CAMERA_EXPOSE,
        (("Light", light), ("fits/IMAGETYP", kind)),
        arguments,
        # From one word of the camera to the next: it says how it stands all the time.
        timeout=120.0,
    )


def _move(role: CommandRole, word: str, name: str, *, low: float | str) -> StandardMethod:
    row = ArgumentRow(
        "position", "Position", "Position", low=low, high="maxstep", type=ArgumentType.INTEGER
    )
    return StandardMethod("move", word, name, "maxstep", role, arguments=(row,), timeout=300.0)


def _gain(needs: str, *, low: float | str, high: str) -> StandardMethod:
    row = ArgumentRow("gain", "Gain", "Gain", low=low, high=high, type=ArgumentType.INTEGER)
    return StandardMethod("gain", "gain", "Gain", needs, _Role.CAMERA_GAIN, arguments=(row,))


_SECONDS = ArgumentRow("seconds", "Duration", "Exposure", "s", "exposuremin", "exposuremax")
_TARGET = ArgumentRow("target", "fits/OBJECT", "Target", type=ArgumentType.TEXT, default="Unknown")
STANDARD_COMMANDS: dict[str, tuple[StandardMethod, ...]] = {
    "telescope": (
        StandardMethod(
            "slewtocoordinatesasync",
            "goto",
            "Go to",
            "canslewasync",
            _Role.TELESCOPE_GOTO,
            arguments=_EQUATORIAL,
            timeout=600.0,
        ),
        StandardMethod(
            "slewtoaltazasync",
            "goto_altaz",
            "Go to altitude and azimuth",
            "canslewaltazasync",
            _Role.NONE,
            arguments=_HORIZONTAL,
            timeout=600.0,
        ),
        StandardMethod(
            "synctocoordinates",
            "sync",
            "Sync",
            "cansync",
            _Role.NONE,
            arguments=_EQUATORIAL,
            # A wrong sync makes every later slew go wrong.
            confirm=True,
            description="The telescope points there now.",
        ),
        StandardMethod("park", "park", "Park", "canpark", _Role.TELESCOPE_PARK, timeout=600.0),
        StandardMethod("unpark", "unpark", "Unpark", "canunpark", _Role.TELESCOPE_UNPARK),
        StandardMethod("findhome", "home", "Find home", "canfindhome", _Role.NONE, timeout=600.0),
        StandardMethod("abortslew", "stop", "Stop", "", _Role.TELESCOPE_STOP),
        StandardMethod("tracking", "track", "Track", "cansettracking", _Role.TELESCOPE_TRACK, _ON),
        StandardMethod(
            "tracking",
            "untrack",
            "Stop tracking",
            "cansettracking",
            _Role.TELESCOPE_UNTRACK,
            (("Tracking", False),),
        ),
    ),
    "dome": (
        StandardMethod(
            "openshutter", "open", "Open", "cansetshutter", _Role.DOME_OPEN, timeout=300.0
        ),
        StandardMethod(
            "closeshutter", "close", "Close", "cansetshutter", _Role.DOME_CLOSE, timeout=300.0
        ),
        StandardMethod("abortslew", "stop", "Stop", "", _Role.DOME_STOP),
        StandardMethod("park", "park", "Park", "canpark", _Role.DOME_PARK, timeout=600.0),
        StandardMethod("findhome", "home", "Find home", "canfindhome", _Role.NONE, timeout=600.0),
        StandardMethod(
            "slewtoazimuth",
            "goto",
            "Turn to",
            "cansetazimuth",
            _Role.DOME_GOTO,
            arguments=(ArgumentRow("azimuth", "Azimuth", "Azimuth", "°", 0.0, 360.0),),
            timeout=600.0,
        ),
        StandardMethod(
            "slaved",
            "slave",
            "Follow the telescope",
            "canslave",
            _Role.NONE,
            arguments=(ArgumentRow("on", "Slaved", "On", type=ArgumentType.BOOLEAN),),
        ),
    ),
    "camera": (
        _frame("expose", "Expose", light=True, kind="Light", arguments=(_SECONDS, _TARGET)),
        _frame("dark", "Dark", light=False, kind="Dark", arguments=(_SECONDS,)),
        _frame(
            "bias",
            "Bias",
            light=False,
            kind="Bias",
            arguments=(_SECONDS._replace(default="exposuremin"),),
        ),
        _frame("flat", "Flat", light=True, kind="Flat", arguments=(_SECONDS,)),
        StandardMethod(
            "binx",
            "binning",
            "Binning",
            "maxbinx",
            _Role.CAMERA_BINNING,
            arguments=(
                ArgumentRow(
                    "factor", "BinX", "Binning", low=1, high="maxbinx", type=ArgumentType.INTEGER
                ),
            ),
        ),
        # A camera has either named gains, of which one is chosen by its place, or a range.
        _gain("gains", low=0, high="gains"),
        _gain("gainmax", low="gainmin", high="gainmax"),
        StandardMethod("abortexposure", "abort", "Abort", "canabortexposure", _Role.CAMERA_ABORT),
        StandardMethod(
            "setccdtemperature",
            "cool",
            "Cool to",
            "cansetccdtemperature",
            _Role.CAMERA_COOL,
            arguments=(
                ArgumentRow("temperature", "SetCCDTemperature", "Temperature", "°C", -100.0, 50.0),
            ),
        ),
        StandardMethod(
            "cooleron",
            "cooler",
            "Cooler",
            "cooleron",
            _Role.CAMERA_COOLER,
            arguments=(ArgumentRow("on", "CoolerOn", "On", type=ArgumentType.BOOLEAN),),
        ),
    ),
    "focuser": (
        _move(_Role.FOCUSER_GOTO, "move", "Move to", low=0),
        # Of one that does not know where it stands; see `discovery`.
        _move(_Role.FOCUSER_MOVE, "move_by", "Move by", low="-maxstep"),
        StandardMethod("halt", "halt", "Halt", "", _Role.FOCUSER_STOP),
    ),
    "filterwheel": (
        StandardMethod(
            "position",
            "select",
            "Select filter",
            "",
            _Role.CAMERA_FILTER,
            # Up to the number of names; see `discovery`.
            arguments=(
                ArgumentRow(
                    "position", "Position", "Filter", low=0, high="names", type=ArgumentType.INTEGER
                ),
            ),
            timeout=120.0,
        ),
    ),
    "rotator": (
        StandardMethod(
            "moveabsolute",
            "move",
            "Turn to",
            "",
            _Role.NONE,
            arguments=(ArgumentRow("angle", "Position", "Angle", "°", 0.0, 360.0),),
            timeout=300.0,
        ),
        StandardMethod("halt", "halt", "Halt", "", _Role.NONE),
    ),
    "covercalibrator": (
        StandardMethod(
            "opencover", "open_cover", "Open the cover", "coverstate", _Role.NONE, timeout=120.0
        ),
        StandardMethod(
            "closecover", "close_cover", "Close the cover", "coverstate", _Role.NONE, timeout=120.0
        ),
        StandardMethod("haltcover", "halt_cover", "Halt the cover", "coverstate", _Role.NONE),
        StandardMethod(
            "calibratoron",
            "light_on",
            "Light on",
            "maxbrightness",
            _Role.NONE,
            arguments=(
                ArgumentRow(
                    "brightness",
                    "Brightness",
                    "Brightness",
                    low=0,
                    high="maxbrightness",
                    type=ArgumentType.INTEGER,
                ),
            ),
        ),
        StandardMethod("calibratoroff", "light_off", "Light off", "maxbrightness", _Role.NONE),
    ),
    "switch": (),
    "observingconditions": (),
    "safetymonitor": (),
}
