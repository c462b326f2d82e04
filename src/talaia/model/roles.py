"""What a signal or a command is: the closed list of roles, and what each may stand on. Pure.

Pages, tiles and summaries are made by role, never by the words of a name. A role is said in the
description, or proposed where it is left out; see `discovery.role_proposal`.

Long, because it is one closed list.
"""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

from talaia.model.closed_lists import SignalType

__all__ = [
    "ANY_MEANINGS",
    "COMMAND_FITS",
    "SIGNAL_FITS",
    "CommandFit",
    "CommandForm",
    "CommandRole",
    "SignalFit",
    "SignalRole",
    "StateMeaning",
]


class SignalRole(StrEnum):
    """What a signal is. ``auto``: what Talaia proposes; ``none``: nothing that a page knows."""

    AUTO = "auto"
    NONE = "none"
    DOME_SHUTTER = "dome.shutter"
    DOME_OPENING = "dome.opening"
    DOME_AZIMUTH = "dome.azimuth"
    DOME_TURNING = "dome.turning"
    DOME_PARKED = "dome.parked"
    DOME_LOCAL = "dome.local"
    TELESCOPE_STATE = "telescope.state"
    TELESCOPE_PARKED = "telescope.parked"
    TELESCOPE_TRACKING = "telescope.tracking"
    TELESCOPE_RA = "telescope.ra"
    TELESCOPE_DEC = "telescope.dec"
    TELESCOPE_ALTITUDE = "telescope.altitude"
    TELESCOPE_AZIMUTH = "telescope.azimuth"
    CAMERA_STATE = "camera.state"
    CAMERA_REMAINING = "camera.remaining"
    CAMERA_TEMPERATURE = "camera.temperature"
    CAMERA_COOLER = "camera.cooler"
    CAMERA_COOLER_POWER = "camera.cooler_power"
    CAMERA_FILTER = "camera.filter"
    CAMERA_BINNING = "camera.binning"
    CAMERA_GAIN = "camera.gain"
    CAMERA_PRESETS = "camera.presets"
    FOCUSER_POSITION = "focuser.position"
    FOCUSER_MOVING = "focuser.moving"
    FOCUSER_TEMPERATURE = "focuser.temperature"
    WEATHER_SAFETY = "weather.safety"
    WEATHER_RAINING = "weather.raining"
    WEATHER_RAIN = "weather.rain"
    WEATHER_WIND = "weather.wind"
    WEATHER_GUST = "weather.gust"
    WEATHER_WIND_DIRECTION = "weather.wind_direction"
    WEATHER_HUMIDITY = "weather.humidity"
    WEATHER_TEMPERATURE = "weather.temperature"
    WEATHER_DEW_POINT = "weather.dew_point"
    WEATHER_PRESSURE = "weather.pressure"
    WEATHER_CLOUDS = "weather.clouds"
    POWER_OUTLET = "power.outlet"
    POWER_TOTAL = "power.total"
    POWER_VOLTAGE = "power.voltage"
    POWER_CURRENT = "power.current"
    POWER_LOAD = "power.load"
    BATTERY_LEVEL = "battery.level"
    BATTERY_VOLTAGE = "battery.voltage"
    BATTERY_CURRENT = "battery.current"
    VEHICLE_SPEED = "vehicle.speed"
    VEHICLE_SIDEWAYS_SPEED = "vehicle.sideways_speed"
    VEHICLE_TURN_RATE = "vehicle.turn_rate"
    VEHICLE_POSITION = "vehicle.position"


class CommandRole(StrEnum):
    """What a command does. ``auto``: what Talaia proposes; ``none``: nothing that a page knows."""

    AUTO = "auto"
    NONE = "none"
    DOME_OPEN = "dome.open"
    DOME_CLOSE = "dome.close"
    DOME_STOP = "dome.stop"
    DOME_PARK = "dome.park"
    DOME_UNPARK = "dome.unpark"
    DOME_GOTO = "dome.goto"
    TELESCOPE_GOTO = "telescope.goto"
    TELESCOPE_TRACK = "telescope.track"
    TELESCOPE_UNTRACK = "telescope.untrack"
    TELESCOPE_PARK = "telescope.park"
    TELESCOPE_UNPARK = "telescope.unpark"
    TELESCOPE_STOP = "telescope.stop"
    CAMERA_EXPOSE = "camera.expose"
    CAMERA_ABORT = "camera.abort"
    CAMERA_COOL = "camera.cool"
    CAMERA_COOLER = "camera.cooler"
    CAMERA_COOLER_ON = "camera.cooler_on"
    CAMERA_COOLER_OFF = "camera.cooler_off"
    CAMERA_FILTER = "camera.filter"
    CAMERA_BINNING = "camera.binning"
    CAMERA_GAIN = "camera.gain"
    CAMERA_GOTO_PRESET = "camera.goto_preset"
    CAMERA_SET_PRESET = "camera.set_preset"
    CAMERA_REMOVE_PRESET = "camera.remove_preset"
    CAMERA_HOME = "camera.home"
    FOCUSER_GOTO = "focuser.goto"
    FOCUSER_MOVE = "focuser.move"
    FOCUSER_IN = "focuser.in"
    FOCUSER_OUT = "focuser.out"
    FOCUSER_STOP = "focuser.stop"
    POWER_SWITCH = "power.switch"
    POWER_ON = "power.on"
    POWER_OFF = "power.off"
    VEHICLE_GOAL = "vehicle.goal"
    VEHICLE_INITIAL_POSE = "vehicle.initial_pose"


class StateMeaning(StrEnum):
    """What one state of a signal means, whatever it is called."""

    CLOSED = "closed"
    OPEN = "open"
    OPENING = "opening"
    CLOSING = "closing"
    PARTIAL = "partial"
    ERROR = "error"
    UNKNOWN = "unknown"
    IDLE = "idle"
    EXPOSING = "exposing"
    READING = "reading"
    SAFE = "safe"
    WARNING = "warning"
    UNSAFE = "unsafe"
    NORMAL = "normal"


class SignalFit(NamedTuple):
    """What a signal must be to have a role.

    Attributes:
        types: one of these.
        units: of a number, one of these; none for any.
        states: of a state: so many; 0 for any number.
        meanings: what its states may mean; none: what those of any signal may, `ANY_MEANINGS`.
        many: several signals of a device may have it.

    """

    types: tuple[SignalType, ...]
    units: tuple[str, ...] = ()
    states: int = 0
    meanings: tuple[StateMeaning, ...] = ()
    many: bool = False

    def allows(self, kind: SignalType, unit: str) -> bool:
        """Tell whether a signal of this type, in this unit, may have the role."""
        return kind in self.types and (
            kind is not SignalType.NUMBER or not self.units or unit in self.units
        )


class CommandForm(StrEnum):
    """What a command asks for; the value is how a message says it."""

    PLAIN = "no argument without a default"
    SWITCH = "one argument, a boolean"
    NUMBER = "one argument, a number"
    NUMBERS = "numbers"
    TEXT = "one argument, a text"
    DURATION = "an argument with the unit s"
    PLACE = "two numbers: right ascension, then declination"
    POSE = (
        "numbers x and y (m), a text frame, and which way: a number yaw (rad or °), or the numbers "
        "qz and qw"
    )


class CommandFit(NamedTuple):
    """What a command must ask for to have a role.

    Attributes:
        forms: one of these.
        unit: of `CommandForm.NUMBER`.
        many: several commands of a device may have it.

    """

    forms: tuple[CommandForm, ...] = (CommandForm.PLAIN,)
    unit: str = ""
    many: bool = False


def _number_fit(*units: str) -> SignalFit:
    return SignalFit((SignalType.NUMBER,), units)


_STATE = SignalFit((SignalType.STATE,))
_OF_SHUTTERS = (
    StateMeaning.CLOSED,
    StateMeaning.OPEN,
    StateMeaning.OPENING,
    StateMeaning.CLOSING,
    StateMeaning.PARTIAL,
    StateMeaning.ERROR,
    StateMeaning.UNKNOWN,
)
_OF_CAMERAS = (
    StateMeaning.IDLE,
    StateMeaning.EXPOSING,
    StateMeaning.READING,
    StateMeaning.ERROR,
    StateMeaning.UNKNOWN,
)
_OF_WEATHER = (
    StateMeaning.SAFE,
    StateMeaning.WARNING,
    StateMeaning.UNSAFE,
    StateMeaning.UNKNOWN,
)

# Of a state without a role, or with one that asks for nothing else.
ANY_MEANINGS = (
    StateMeaning.NORMAL,
    StateMeaning.WARNING,
    StateMeaning.ERROR,
    StateMeaning.UNKNOWN,
)

SIGNAL_FITS: dict[SignalRole, SignalFit] = {
    SignalRole.DOME_SHUTTER: SignalFit((SignalType.STATE,), meanings=_OF_SHUTTERS),
    SignalRole.DOME_OPENING: _number_fit("%"),
    SignalRole.DOME_AZIMUTH: _number_fit("°"),
    SignalRole.DOME_TURNING: _STATE,
    SignalRole.DOME_PARKED: _STATE,
    SignalRole.DOME_LOCAL: _STATE,
    SignalRole.TELESCOPE_STATE: _STATE,
    SignalRole.TELESCOPE_PARKED: _STATE,
    SignalRole.TELESCOPE_TRACKING: _STATE,
    SignalRole.TELESCOPE_RA: _number_fit("h", "°"),
    SignalRole.TELESCOPE_DEC: _number_fit("°"),  # drivers give either
    SignalRole.TELESCOPE_ALTITUDE: _number_fit("°"),
    SignalRole.TELESCOPE_AZIMUTH: _number_fit("°"),
    SignalRole.CAMERA_STATE: SignalFit((SignalType.STATE,), meanings=_OF_CAMERAS),
    SignalRole.CAMERA_REMAINING: _number_fit("s"),
    SignalRole.CAMERA_TEMPERATURE: _number_fit("°C", "K"),
    SignalRole.CAMERA_COOLER: _STATE,
    SignalRole.CAMERA_COOLER_POWER: _number_fit("%"),
    SignalRole.CAMERA_FILTER: SignalFit((SignalType.STATE, SignalType.TEXT, SignalType.NUMBER)),
    SignalRole.CAMERA_BINNING: SignalFit((SignalType.NUMBER,), ("",)),
    SignalRole.CAMERA_GAIN: SignalFit((SignalType.NUMBER,)),
    # One name a line.
    SignalRole.CAMERA_PRESETS: SignalFit((SignalType.TEXT,)),
    SignalRole.FOCUSER_POSITION: SignalFit((SignalType.NUMBER,)),
    SignalRole.FOCUSER_MOVING: _STATE,
    SignalRole.FOCUSER_TEMPERATURE: _number_fit("°C", "K"),
    SignalRole.WEATHER_SAFETY: SignalFit((SignalType.STATE,), meanings=_OF_WEATHER),
    SignalRole.WEATHER_RAINING: _STATE,
    SignalRole.WEATHER_RAIN: _number_fit("mm/h", "mm"),
    SignalRole.WEATHER_WIND: _number_fit("km/h", "m/s"),
    SignalRole.WEATHER_GUST: _number_fit("km/h", "m/s"),
    SignalRole.WEATHER_WIND_DIRECTION: _number_fit("°"),
    SignalRole.WEATHER_HUMIDITY: _number_fit("%"),
    SignalRole.WEATHER_TEMPERATURE: _number_fit("°C", "K"),
    SignalRole.WEATHER_DEW_POINT: _number_fit("°C", "K"),
    SignalRole.WEATHER_PRESSURE: _number_fit("hPa", "Pa"),
    SignalRole.WEATHER_CLOUDS: _number_fit("%"),
    # The first of its states is off, the second on.
    SignalRole.POWER_OUTLET: SignalFit((SignalType.STATE,), states=2, many=True),
    SignalRole.POWER_TOTAL: _number_fit("W"),
    SignalRole.POWER_VOLTAGE: _number_fit("V", "mV"),
    SignalRole.POWER_CURRENT: _number_fit("A"),
    SignalRole.POWER_LOAD: _number_fit("%"),
    SignalRole.BATTERY_LEVEL: _number_fit("%"),
    SignalRole.BATTERY_VOLTAGE: _number_fit("V", "mV"),
    SignalRole.BATTERY_CURRENT: _number_fit("A"),
    SignalRole.VEHICLE_SPEED: _number_fit("m/s", "km/h"),
    SignalRole.VEHICLE_SIDEWAYS_SPEED: _number_fit("m/s", "km/h"),
    SignalRole.VEHICLE_TURN_RATE: _number_fit("rad/s", "°/s"),
    SignalRole.VEHICLE_POSITION: SignalFit((SignalType.POSITION,)),
}

_PLAIN = CommandFit()
# Short, so that each row fits a line.
_ROLE = CommandRole

COMMAND_FITS: dict[CommandRole, CommandFit] = {
    _ROLE.DOME_OPEN: _PLAIN,
    _ROLE.DOME_CLOSE: _PLAIN,
    _ROLE.DOME_STOP: _PLAIN,
    _ROLE.DOME_PARK: _PLAIN,
    _ROLE.DOME_UNPARK: _PLAIN,
    _ROLE.DOME_GOTO: CommandFit((CommandForm.NUMBER,), "°"),
    _ROLE.TELESCOPE_GOTO: CommandFit((CommandForm.PLACE,)),
    # Some mounts have one switch, others two commands.
    _ROLE.TELESCOPE_TRACK: CommandFit((CommandForm.SWITCH, CommandForm.PLAIN)),
    _ROLE.TELESCOPE_UNTRACK: _PLAIN,
    _ROLE.TELESCOPE_PARK: _PLAIN,
    _ROLE.TELESCOPE_UNPARK: _PLAIN,
    _ROLE.TELESCOPE_STOP: _PLAIN,
    _ROLE.CAMERA_EXPOSE: CommandFit((CommandForm.DURATION,), many=True),
    _ROLE.CAMERA_ABORT: _PLAIN,
    _ROLE.CAMERA_COOL: CommandFit((CommandForm.NUMBER,), "°C", many=True),
    _ROLE.CAMERA_COOLER: CommandFit((CommandForm.SWITCH,)),
    _ROLE.CAMERA_COOLER_ON: _PLAIN,
    _ROLE.CAMERA_COOLER_OFF: _PLAIN,
    # A place of the wheel, or a name.
    _ROLE.CAMERA_FILTER: CommandFit((CommandForm.NUMBER, CommandForm.TEXT)),
    # Some drivers want it for each axis.
    _ROLE.CAMERA_BINNING: CommandFit((CommandForm.NUMBERS,)),
    _ROLE.CAMERA_GAIN: CommandFit((CommandForm.NUMBER,)),
    # The name of a preset.
    _ROLE.CAMERA_GOTO_PRESET: CommandFit((CommandForm.TEXT,)),
    _ROLE.CAMERA_SET_PRESET: CommandFit((CommandForm.TEXT,)),
    _ROLE.CAMERA_REMOVE_PRESET: CommandFit((CommandForm.TEXT,)),
    _ROLE.CAMERA_HOME: _PLAIN,
    _ROLE.FOCUSER_GOTO: CommandFit((CommandForm.NUMBER,)),
    _ROLE.FOCUSER_MOVE: CommandFit((CommandForm.NUMBER,)),
    _ROLE.FOCUSER_IN: CommandFit((CommandForm.NUMBER,)),
    _ROLE.FOCUSER_OUT: CommandFit((CommandForm.NUMBER,)),
    _ROLE.FOCUSER_STOP: _PLAIN,
    _ROLE.POWER_SWITCH: CommandFit((CommandForm.SWITCH,), many=True),
    _ROLE.POWER_ON: CommandFit(many=True),
    _ROLE.POWER_OFF: CommandFit(many=True),
    _ROLE.VEHICLE_GOAL: CommandFit((CommandForm.POSE,)),
    _ROLE.VEHICLE_INITIAL_POSE: CommandFit((CommandForm.POSE,)),
}
