"""Which signal of a device is its shutter, its azimuth, its charge, where nobody says it. Pure.

Long, because each kind of device has its own rules, and they are compared with each other.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from talaia.model.connection import OnvifSource, RosSource
from talaia.model.discovery.role_words import first_named, first_of, has_word, signals_that
from talaia.model.roles import SignalRole
from talaia.model.site import DeviceKind, PositionFrame, SignalType

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.site import Device, Signal

__all__ = ["SignalRoles"]

_CLOSED = re.compile(r"clos(ed|e)?", re.IGNORECASE)
_OPEN = re.compile(r"open(ed)?", re.IGNORECASE)
_PARKED = re.compile(r"parked", re.IGNORECASE)
_OFF = re.compile(r"off|no|false|0|open", re.IGNORECASE)  # an open contact: no current
_ON = re.compile(r"on|yes|true|1|closed", re.IGNORECASE)  # a closed one: current flows


class SignalRoles:
    """The roles of a device's signals, as they are found: those that are said come first.

    Attributes:
        roles: by the signal's id.

    """

    def __init__(self, device: Device) -> None:
        """Begin with what the description says."""
        self._device = device
        self.roles: dict[str, SignalRole] = {
            name: signal.role
            for name, signal in device.signals.items()
            if signal.role not in {SignalRole.AUTO, SignalRole.NONE}
        }

    def propose_roles(self) -> None:
        """Find the others, by the kind of the device."""
        match self._device.kind:
            case DeviceKind.DOME:
                self._propose_dome()
            case DeviceKind.TELESCOPE:
                self._propose_telescope()
            case DeviceKind.CAMERA:
                self._propose_camera()
            case DeviceKind.WEATHER:
                self._propose_weather()
            case DeviceKind.POWER:
                self._propose_power()
            case DeviceKind.VEHICLE:
                self._propose_vehicle()
            case DeviceKind.OTHER:
                # A robot's filters are of another kind.
                if has_word("", self._device.name, "filter", "filterwheel"):
                    self._propose_filter()
        self._propose_focuser()
        self._propose_batteries()  # last: any device may carry one

    # ── what is there to choose from ──

    def _free_signals(self) -> dict[str, Signal]:
        """Give the signals that a role can still be proposed for."""
        return {
            name: signal
            for name, signal in self._device.signals.items()
            if signal.role is SignalRole.AUTO and name not in self.roles
        }

    def _state_signals(self) -> dict[str, Signal]:
        return {
            name: signal
            for name, signal in self._free_signals().items()
            if signal.type is SignalType.STATE
        }

    def _number_signals(self, *units: str) -> dict[str, Signal]:
        return {
            name: signal
            for name, signal in self._free_signals().items()
            if signal.type is SignalType.NUMBER and signal.unit in units
        }

    def _assign_role(self, role: SignalRole, *choices: str | None) -> None:
        """Give the role to the first choice that there is, if nobody has it yet."""
        name = next((choice for choice in choices if choice is not None), None)
        if name is not None and role not in self.roles.values():
            self.roles[name] = role

    # ── kind by kind ──

    def _propose_dome(self) -> None:
        shutters = signals_that(
            self._state_signals(),
            lambda found: _has_state(found, _CLOSED) and _has_state(found, _OPEN),
        )
        self._assign_role(
            SignalRole.DOME_SHUTTER,
            first_named(shutters, "shutter", "roof", "enclosure", "state"),
            first_of(shutters),
        )
        self._assign_role(
            SignalRole.DOME_OPENING,
            first_named(
                self._number_signals("%"), "position", "opening", "shutter", "roof", "open"
            ),
        )
        self._assign_role(
            SignalRole.DOME_AZIMUTH,
            first_named(self._number_signals("°"), "azimuth", "az", "heading", "rotation"),
        )
        self._assign_role(
            SignalRole.DOME_TURNING,
            first_named(self._state_signals(), "turning", "rotating", "moving"),
        )
        parked = signals_that(self._state_signals(), lambda found: _has_state(found, _PARKED))
        self._assign_role(
            SignalRole.DOME_PARKED,
            first_of({name: found for name, found in parked.items() if name not in shutters}),
            first_named(self._state_signals(), "parked"),
        )
        self._assign_role(
            SignalRole.DOME_LOCAL,
            first_of(
                signals_that(
                    self._state_signals(),
                    lambda found: (
                        _has_state(found, re.compile("local", re.IGNORECASE))
                        and _has_state(found, re.compile("remote", re.IGNORECASE))
                    ),
                )
            ),
        )

    def _propose_telescope(self) -> None:
        moves = re.compile(r"slewing|tracking", re.IGNORECASE)
        self._assign_role(
            SignalRole.TELESCOPE_STATE,
            first_of(signals_that(self._state_signals(), lambda found: _has_state(found, moves))),
        )
        self._assign_role(
            SignalRole.TELESCOPE_PARKED,
            first_of(signals_that(self._state_signals(), lambda found: _has_state(found, _PARKED))),
        )
        self._assign_role(
            SignalRole.TELESCOPE_TRACKING, first_named(self._state_signals(), "tracking", "track")
        )
        self._assign_role(
            SignalRole.TELESCOPE_RA,
            first_named(self._number_signals("h"), "ra", "right"),
            first_named(self._angle_signals(), "ra", "right"),
        )
        self._assign_role(
            SignalRole.TELESCOPE_DEC, first_named(self._angle_signals(), "dec", "declination")
        )
        self._assign_role(
            SignalRole.TELESCOPE_ALTITUDE,
            first_named(self._angle_signals(), "altitude", "alt", "elevation"),
        )
        self._assign_role(
            SignalRole.TELESCOPE_AZIMUTH, first_named(self._angle_signals(), "azimuth", "az")
        )

    def _angle_signals(self) -> dict[str, Signal]:
        """Give what may be the telescope's own angle: the Sun's altitude is another matter."""
        return {
            name: signal
            for name, signal in self._number_signals("°").items()
            if not has_word(name, signal.name, "sun", "moon")
        }

    def _propose_camera(self) -> None:
        for name, signal in self._free_signals().items():
            if isinstance(signal.source, OnvifSource) and signal.source.ptz == "presets":
                self._assign_role(SignalRole.CAMERA_PRESETS, name)
        exposes = re.compile(r"expos(ing|ure)", re.IGNORECASE)
        self._assign_role(
            SignalRole.CAMERA_STATE,
            first_of(signals_that(self._state_signals(), lambda found: _has_state(found, exposes))),
        )
        self._assign_role(
            SignalRole.CAMERA_REMAINING,
            first_named(self._number_signals("s"), "remaining", "exposure", "left"),
        )
        self._assign_role(
            SignalRole.CAMERA_TEMPERATURE,
            first_named(self._number_signals("°C"), "temperature", "chip", "sensor", "ccd"),
        )
        self._assign_role(
            SignalRole.CAMERA_COOLER, first_named(self._state_signals(), "cooler", "cooling")
        )
        self._assign_role(
            SignalRole.CAMERA_COOLER_POWER,
            first_named(self._number_signals("%"), "cooler", "cooler_power", "power"),
        )
        self._propose_filter()
        self._assign_role(
            SignalRole.CAMERA_BINNING, first_named(self._number_signals(""), "binning")
        )
        self._assign_role(SignalRole.CAMERA_GAIN, first_named(self._number_signals(""), "gain"))

    def _propose_filter(self) -> None:
        filters = {
            name: signal
            for name, signal in self._free_signals().items()
            if signal.type is not SignalType.POSITION and has_word(name, signal.name, "filter")
        }
        self._assign_role(SignalRole.CAMERA_FILTER, first_of(filters))

    def _propose_focuser(self) -> None:
        """Find a focuser's own: of a device of that name, or by words of its own."""
        own = has_word("", self._device.name, "focuser", "focus")
        place = ("focus", "position") if own else ("focus",)
        self._assign_role(
            SignalRole.FOCUSER_POSITION,
            first_of(
                {name: found for name, found in self._number_signals("").items() if name in place}
            ),
        )
        warm = ("focuser_temperature", "temperature") if own else ("focuser_temperature",)
        self._assign_role(
            SignalRole.FOCUSER_TEMPERATURE,
            first_of(
                {name: found for name, found in self._number_signals("°C").items() if name in warm}
            ),
        )
        if own:
            self._assign_role(
                SignalRole.FOCUSER_MOVING, first_named(self._state_signals(), "moving")
            )

    def _propose_weather(self) -> None:
        safe = re.compile(r"(un)?safe", re.IGNORECASE)
        self._assign_role(
            SignalRole.WEATHER_SAFETY,
            first_of(signals_that(self._state_signals(), lambda found: _has_state(found, safe))),
        )
        self._assign_role(
            SignalRole.WEATHER_RAINING,
            first_of(
                {
                    name: signal
                    for name, signal in self._state_signals().items()
                    if has_word(name, signal.name, "rain", "raining")
                }
            ),
        )
        self._assign_role(
            SignalRole.WEATHER_WIND, first_named(self._number_signals("km/h", "m/s"), "wind")
        )
        for role, units, words in (
            (SignalRole.WEATHER_GUST, ("km/h", "m/s"), ("gust", "gusts")),
            (SignalRole.WEATHER_WIND_DIRECTION, ("°",), ("wind_from", "direction", "wind")),
            (SignalRole.WEATHER_HUMIDITY, ("%",), ("humidity",)),
            (SignalRole.WEATHER_CLOUDS, ("%",), ("clouds", "cloud")),
            (SignalRole.WEATHER_TEMPERATURE, ("°C",), ("temperature",)),
            (SignalRole.WEATHER_DEW_POINT, ("°C",), ("dew_point", "dew", "dewpoint")),
            (SignalRole.WEATHER_PRESSURE, ("hPa", "Pa"), ("pressure", "barometer")),
            (SignalRole.WEATHER_RAIN, ("mm/h", "mm"), ("rain",)),
        ):
            self._assign_role(role, first_named(self._number_signals(*units), *words))

    def _propose_power(self) -> None:
        for name, signal in self._state_signals().items():
            if _is_switch(signal):
                self.roles[name] = SignalRole.POWER_OUTLET
        self._assign_role(SignalRole.POWER_TOTAL, first_of(self._number_signals("W")))
        for unit, plain, of_battery in (
            ("V", SignalRole.POWER_VOLTAGE, SignalRole.BATTERY_VOLTAGE),
            ("A", SignalRole.POWER_CURRENT, SignalRole.BATTERY_CURRENT),
            ("%", SignalRole.POWER_LOAD, SignalRole.BATTERY_LEVEL),
        ):
            # A page shows one of each unit: the first.
            if not {plain, of_battery}.isdisjoint(self.roles.values()):
                continue
            for name, signal in list(self._number_signals(unit).items())[:1]:
                battery = _is_of_battery(name, signal)
                self._assign_role(of_battery if battery else plain, name)

    def _propose_vehicle(self) -> None:
        self._assign_role(
            SignalRole.VEHICLE_SPEED,
            _read_from(self._number_signals("m/s", "km/h"), "nav_msgs/msg/Odometry", "linear.x"),
            first_named(self._number_signals("m/s", "km/h"), "speed"),
        )
        self._assign_role(
            SignalRole.VEHICLE_SIDEWAYS_SPEED,
            _read_from(self._number_signals("m/s", "km/h"), "nav_msgs/msg/Odometry", "linear.y"),
        )
        self._assign_role(
            SignalRole.VEHICLE_TURN_RATE,
            _read_from(self._number_signals("rad/s", "°/s"), "nav_msgs/msg/Odometry", "angular.z"),
            first_named(self._number_signals("rad/s", "°/s"), "turn_rate", "turn"),
        )
        places = signals_that(self._free_signals(), lambda found: found.type is SignalType.POSITION)
        self._assign_role(
            SignalRole.VEHICLE_POSITION,
            first_of(signals_that(places, lambda found: found.frame is PositionFrame.LOCAL)),
            first_of(places),
        )

    def _propose_batteries(self) -> None:
        """Say of a battery's own message what it holds, whatever device it is at."""
        message = "sensor_msgs/msg/BatteryState"
        taken = set(self.roles.values())
        for role, plain, units, field in (
            (SignalRole.BATTERY_LEVEL, SignalRole.POWER_LOAD, ("%",), "percentage"),
            (SignalRole.BATTERY_VOLTAGE, SignalRole.POWER_VOLTAGE, ("V", "mV"), "voltage"),
            (SignalRole.BATTERY_CURRENT, SignalRole.POWER_CURRENT, ("A",), "current"),
        ):
            # A page shows either, and what it shows already stays.
            if plain not in taken:
                self._assign_role(role, _read_from(self._number_signals(*units), message, field))


def _has_state(signal: Signal, shape: re.Pattern[str]) -> bool:
    return any(shape.fullmatch(word) for word in signal.states)


def _is_switch(signal: Signal) -> bool:
    return (
        signal.type is SignalType.STATE
        and len(signal.states) == 2
        and _OFF.fullmatch(signal.states[0]) is not None
        and _ON.fullmatch(signal.states[1]) is not None
    )


def _read_from(signals: Mapping[str, Signal], message: str, field: str) -> str | None:
    """Name the first that a field of such a message gives."""
    for name, signal in signals.items():
        source = signal.source
        if (
            isinstance(source, RosSource)
            and source.type == message
            and f".{source.field}".endswith(f".{field}")
        ):
            return name
    return None


def _is_of_battery(name: str, signal: Signal) -> bool:
    source = signal.source
    message = source.type if isinstance(source, RosSource) else ""
    return message == "sensor_msgs/msg/BatteryState" or has_word(
        name, signal.name, "battery", "charge", "soc"
    )
