"""What our devices answer as ASCOM's Dome, ObservingConditions and SafetyMonitor. Pure.

After "ASCOM Master Interfaces" (IDomeV3, IObservingConditionsV2, ISafetyMonitorV3). What is not
known is an error with ASCOM's number for it, and never a number that looks like one.

Long, because what each property and method of the three types means stands in one place.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.model.roles import CommandRole, SignalRole, StateMeaning
from talaia.model.units.quantity import quantity_of_unit

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.hub.clients.alpaca.site_values import SiteValues
    from talaia.wire.frames import Scalar

__all__ = [
    "INVALID_OPERATION",
    "INVALID_VALUE",
    "NOT_IMPLEMENTED",
    "VALUE_NOT_SET",
    "AlpacaDevice",
    "DeviceError",
    "DomeCommand",
    "alpaca_devices",
    "answer_property",
    "asked_command",
]

NOT_IMPLEMENTED = 0x400
INVALID_VALUE = 0x401
VALUE_NOT_SET = 0x402
INVALID_OPERATION = 0x40B
_INTERFACES = {"dome": 3, "observingconditions": 2, "safetymonitor": 3}
# ASCOM's property: our role, and ASCOM's unit.
_SENSORS: dict[str, tuple[SignalRole, str]] = {
    "temperature": (SignalRole.WEATHER_TEMPERATURE, "°C"),
    "humidity": (SignalRole.WEATHER_HUMIDITY, "%"),
    "dewpoint": (SignalRole.WEATHER_DEW_POINT, "°C"),
    "windspeed": (SignalRole.WEATHER_WIND, "m/s"),
    "windgust": (SignalRole.WEATHER_GUST, "m/s"),
    "winddirection": (SignalRole.WEATHER_WIND_DIRECTION, "°"),
    "rainrate": (SignalRole.WEATHER_RAIN, "mm/h"),
    "cloudcover": (SignalRole.WEATHER_CLOUDS, "%"),
    "pressure": (SignalRole.WEATHER_PRESSURE, "hPa"),
}
_OTHER_SENSORS = frozenset({"skytemperature", "skybrightness", "skyquality", "starfwhm"})
# What means neither open nor closed is ASCOM's shutterError: nobody may image through it.
_SHUTTER = {
    StateMeaning.OPEN: 0,
    StateMeaning.CLOSED: 1,
    StateMeaning.OPENING: 2,
    StateMeaning.CLOSING: 3,
    StateMeaning.PARTIAL: 4,
    StateMeaning.ERROR: 4,
}
# ASCOM's method, and the role of our command.
_METHODS = {
    "openshutter": CommandRole.DOME_OPEN,
    "closeshutter": CommandRole.DOME_CLOSE,
    "abortslew": CommandRole.DOME_STOP,
    "park": CommandRole.DOME_PARK,
    "slewtoazimuth": CommandRole.DOME_GOTO,
}


_NEVER_ABLE = frozenset(
    {"canfindhome", "cansetaltitude", "cansetpark", "canslave", "cansyncazimuth"}
)


class DeviceError(Exception):
    """A device answers with an error of ASCOM's.

    Attributes:
        number: ASCOM's.

    """

    def __init__(self, number: int, words: str) -> None:
        """Keep the number beside the words."""
        super().__init__(words)
        self.number = number


class AlpacaDevice(NamedTuple):
    """A device that is served.

    Attributes:
        type: ASCOM's, ``dome``.
        number: among those of its type.
        name: for people.
        device: ours; empty for the safety of the whole site.

    """

    type: str
    number: int
    name: str
    device: str


class DomeCommand(NamedTuple):
    """A command of ours that a client asks for, with its arguments."""

    device: str
    command: str
    args: dict[str, Scalar]


def alpaca_devices(values: SiteValues) -> list[AlpacaDevice]:
    """List what is served of a site: each dome, each weather station, and its safety."""
    made: list[AlpacaDevice] = []
    numbers: dict[str, int] = {}

    def add_device(kind: str, name: str, device: str) -> None:
        number = numbers.setdefault(kind, 0)
        numbers[kind] = number + 1
        made.append(AlpacaDevice(kind, number, name, device))

    for device, described in values.devices():
        if values.signals_of(device, SignalRole.DOME_SHUTTER):
            add_device("dome", described.name, device)
        if any(values.signals_of(device, role) for role, _ in _SENSORS.values()):
            add_device("observingconditions", described.name, device)
    add_device("safetymonitor", f"Safety of {values.live.description.name}", "")
    return made


def answer_property(
    device: AlpacaDevice,
    name: str,
    arguments: Mapping[str, str],
    *,
    values: SiteValues,
    permits: Callable[[str, str], bool],
) -> object:
    """Answer what a client asks of a device.

    Args:
        device: which.
        name: the property, in small letters.
        arguments: the question's parameters, their names in small letters.
        values: of the site, now.
        permits: tells of a device and command whether clients may call it.

    Raises:
        DeviceError: it is not known, or the device has no such thing.

    """
    common: dict[str, object] = {
        # Ours are connected as long as the hub runs; what is not known is said where it is asked.
        "connected": True,
        "connecting": False,
        "name": device.name,
        "description": f"{device.name}, by Talaia",
        "driverinfo": "Talaia, https://talaia.invalid",
        "driverversion": "1.0",
        "interfaceversion": _INTERFACES[device.type],
        "supportedactions": [],
    }
    if name in common:
        return common[name]
    if name == "devicestate":
        return _device_state(device, values, permits)
    match device.type:
        case "safetymonitor" if name == "issafe":
            return not values.unsafe_reason()
        case "observingconditions":
            return _weather_answer(device, name, arguments, values)
        case "dome":
            return _dome_answer(device, name, values, permits)
        case _:
            pass
    raise DeviceError(NOT_IMPLEMENTED, f"there is no {name}")


def _device_state(
    device: AlpacaDevice, values: SiteValues, permits: Callable[[str, str], bool]
) -> list[dict[str, object]]:
    """Give what is known of a device in one answer, under ASCOM's names."""
    names = {
        "safetymonitor": {"issafe": "IsSafe"},
        "observingconditions": {
            "temperature": "Temperature",
            "humidity": "Humidity",
            "dewpoint": "DewPoint",
            "windspeed": "WindSpeed",
            "windgust": "WindGust",
            "winddirection": "WindDirection",
            "rainrate": "RainRate",
            "cloudcover": "CloudCover",
            "pressure": "Pressure",
        },
        "dome": {
            "azimuth": "Azimuth",
            "atpark": "AtPark",
            "shutterstatus": "ShutterStatus",
            "slewing": "Slewing",
        },
    }[device.type]
    state: list[dict[str, object]] = []
    for name, shown in names.items():
        try:
            value = answer_property(device, name, {}, values=values, permits=permits)
        except DeviceError:
            continue
        state.append({"Name": shown, "Value": value})
    return state


def _weather_answer(
    device: AlpacaDevice, name: str, arguments: Mapping[str, str], values: SiteValues
) -> object:
    if name == "averageperiod":
        return 0.0
    if name in ("timesincelastupdate", "sensordescription"):
        sensor = arguments.get("sensorname", "").lower()
        if not sensor and name == "timesincelastupdate":
            ages = [values.age_s(device.device, role) for role, _ in _SENSORS.values()]
            known = [age for age in ages if age is not None]
            if known:
                return min(known)
            raise DeviceError(VALUE_NOT_SET, "nothing is known of the weather")
        if sensor not in _SENSORS and sensor not in _OTHER_SENSORS:
            raise DeviceError(INVALID_VALUE, f"there is no sensor {sensor[:40]!r}")
        role = _role_of_sensor(device, sensor, values)
        if name == "sensordescription":
            return values.signals_of(device.device, role)[0][1].name
        age = values.age_s(device.device, role)
        if age is None:
            raise DeviceError(VALUE_NOT_SET, f"{sensor} is not known")
        return age
    if name not in _SENSORS:
        raise DeviceError(NOT_IMPLEMENTED, f"there is no {name}")
    role = _role_of_sensor(device, name, values)
    found = values.number(device.device, role)
    if found is None:
        raise DeviceError(VALUE_NOT_SET, f"{name} is not known")
    value, unit = found
    converted = _in_unit(value, unit, _SENSORS[name][1])
    if converted is None:
        raise DeviceError(NOT_IMPLEMENTED, f"{name} is measured in {unit or 'no unit'}")
    return converted


def _in_unit(value: float, unit: str, wanted: str) -> float | None:
    """Give a value in ASCOM's unit; none where it cannot be told in it."""
    if unit == wanted:
        return value
    have, want = quantity_of_unit(unit), quantity_of_unit(wanted)
    if have.powers is None or have.powers != want.powers or not (have.factor and want.factor):
        return None
    return (value * have.factor + have.zero - want.zero) / want.factor


def _role_of_sensor(device: AlpacaDevice, sensor: str, values: SiteValues) -> SignalRole:
    """Give the role of a sensor that a device has.

    Raises:
        DeviceError: it has none.

    """
    role = _SENSORS[sensor][0] if sensor in _SENSORS else None
    if role is None or not values.signals_of(device.device, role):
        raise DeviceError(NOT_IMPLEMENTED, f"there is no {sensor}")
    return role


def _dome_answer(
    device: AlpacaDevice, name: str, values: SiteValues, permits: Callable[[str, str], bool]
) -> object:
    able = {
        "canpark": CommandRole.DOME_PARK,
        "cansetazimuth": CommandRole.DOME_GOTO,
        "cansetshutter": CommandRole.DOME_CLOSE,
    }
    if name in able:
        return bool(_command_of(device, able[name], values, permits))
    if name in _NEVER_ABLE:
        return False
    shutter = values.meaning(device.device, SignalRole.DOME_SHUTTER)
    match name:
        case "shutterstatus":
            if shutter not in _SHUTTER:
                raise DeviceError(VALUE_NOT_SET, "how the shutter stands is not known")
            return _SHUTTER[shutter]
        case "slewing":
            turning = None
            if values.signals_of(device.device, SignalRole.DOME_TURNING):
                turning = values.truth(device.device, SignalRole.DOME_TURNING)
                if turning is None:
                    raise DeviceError(VALUE_NOT_SET, "whether the dome turns is not known")
            return bool(turning) or shutter in (StateMeaning.OPENING, StateMeaning.CLOSING)
        case "slaved":
            return False
        case "azimuth" if values.signals_of(device.device, SignalRole.DOME_AZIMUTH):
            found = values.number(device.device, SignalRole.DOME_AZIMUTH)
            if found is None:
                raise DeviceError(VALUE_NOT_SET, "the dome's azimuth is not known")
            return found[0] % 360.0
        case "atpark" if values.signals_of(device.device, SignalRole.DOME_PARKED):
            parked = values.truth(device.device, SignalRole.DOME_PARKED)
            if parked is None:
                raise DeviceError(VALUE_NOT_SET, "whether the dome is parked is not known")
            return parked
        case _:
            pass
    raise DeviceError(NOT_IMPLEMENTED, f"there is no {name}")


def asked_command(
    device: AlpacaDevice,
    method: str,
    arguments: Mapping[str, str],
    *,
    values: SiteValues,
    permits: Callable[[str, str], bool],
) -> DomeCommand | None:
    """Give the command of ours that a method stands for; none where there is nothing to do.

    Args:
        device: which.
        method: in small letters.
        arguments: its parameters, their names in small letters.
        values: of the site, now.
        permits: see `answer_property`.

    Raises:
        DeviceError: there is no such method, or clients may not call it.

    """
    if method in ("connected", "connect", "disconnect"):
        # A client's own matter: what is served is there for all of them.
        return None
    if device.type == "dome" and method == "slaved":
        if arguments.get("slaved", "").lower() == "false":
            return None
        raise DeviceError(NOT_IMPLEMENTED, "the dome is not slaved from here")
    role = _METHODS.get(method) if device.type == "dome" else None
    if role is None:
        raise DeviceError(NOT_IMPLEMENTED, f"there is no {method}, or it is not offered here")
    command = _command_of(device, role, values, permits)
    if not command:
        raise DeviceError(NOT_IMPLEMENTED, f"{method} is not permitted here; see the hub's file")
    args: dict[str, Scalar] = {}
    if role is CommandRole.DOME_GOTO:
        try:
            azimuth = float(arguments.get("azimuth", ""))
        except ValueError:
            azimuth = -1.0
        if not 0.0 <= azimuth <= 360.0:
            raise DeviceError(INVALID_VALUE, "Azimuth: expected 0 to 360")
        described = values.live.description.devices[device.device].commands[command]
        # The role allows one number, whatever it is called.
        for name in list(described.arguments)[:1]:
            args[name] = azimuth
    return DomeCommand(device.device, command, args)


def _command_of(
    device: AlpacaDevice,
    role: CommandRole,
    values: SiteValues,
    permits: Callable[[str, str], bool],
) -> str:
    """Name the command of a role that clients may call; empty if there is none."""
    described = dict(values.devices()).get(device.device)
    commands = {} if described is None else described.commands
    names = [name for name, command in commands.items() if command.role is role]
    permitted = [name for name in names if permits(device.device, name)]
    # Who may do anything with a dome may close it.
    if not permitted and role is CommandRole.DOME_CLOSE:
        anything = any(permits(device.device, name) for name in commands)
        return names[0] if names and anything else ""
    return permitted[0] if permitted else ""
