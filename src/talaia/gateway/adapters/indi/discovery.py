"""From what a driver says of itself to a device with a page: signals and commands. Pure.

Standard properties get the field's names and units; whatever else a driver has is shown by its
own labels. Property names are INDI's (`observatory` drivers of libindi 1.9.9, ``DRIVER_INFO``'s
interface bits from its ``basedevice.h``).

Long, because the standard properties stand here in tables.
"""

from __future__ import annotations

import re
import unicodedata
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.adapters.indi.goals import CHOICE
from talaia.gateway.adapters.indi.protocol import PropertyPermission, SwitchRule, VectorKind
from talaia.gateway.adapters.indi.standard_properties import MESSAGE, moving_words
from talaia.model.connection import IndiSource
from talaia.model.site import (
    Argument,
    ArgumentType,
    Command,
    CommandKind,
    Device,
    DeviceKind,
    Signal,
    SignalType,
)

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.gateway.adapters.indi.protocol import Element
    from talaia.gateway.adapters.indi.state import IndiDevice, StoredVector

__all__ = ["Interface", "devices_of", "word_of"]

MAX_SIGNALS = 80
MAX_COMMANDS = 60
_MAX_WORD = 64


class Interface:
    """The bits of ``DRIVER_INTERFACE``."""

    TELESCOPE = 1
    CCD = 2
    GUIDER = 4
    FOCUSER = 8
    FILTER = 16
    DOME = 32
    GPS = 64
    WEATHER = 128
    ROTATOR = 4096


class _Number(NamedTuple):
    """A standard number: where it is, and what people call it."""

    property: str
    element: str
    id: str
    name: str
    unit: str = ""
    low: float | None = None
    high: float | None = None
    primary: bool = True
    decimals: int = -1


_NUMBERS = (
    _Number("EQUATORIAL_EOD_COORD", "RA", "ra", "Right ascension (JNow)", "h", 0, 24, decimals=4),
    _Number("EQUATORIAL_EOD_COORD", "DEC", "dec", "Declination (JNow)", "°", -90, 90, decimals=3),
    _Number("HORIZONTAL_COORD", "AZ", "azimuth", "Azimuth", "°", 0, 360),
    _Number("HORIZONTAL_COORD", "ALT", "altitude", "Altitude", "°", -90, 90),
    _Number("GEOGRAPHIC_COORD", "LAT", "latitude", "Latitude", "°", -90, 90, primary=False),
    _Number("GEOGRAPHIC_COORD", "LONG", "longitude", "Longitude east", "°", 0, 360, primary=False),
    _Number("GEOGRAPHIC_COORD", "ELEV", "elevation", "Elevation", "m", primary=False),
    _Number("ABS_DOME_POSITION", "DOME_ABSOLUTE_POSITION", "azimuth", "Azimuth", "°", 0, 360),
    _Number("CCD_EXPOSURE", "CCD_EXPOSURE_VALUE", "exposure", "Exposure left", "s", 0),
    _Number("CCD_TEMPERATURE", "CCD_TEMPERATURE_VALUE", "temperature", "Sensor", "°C", -100, 60),
    _Number("CCD_COOLER_POWER", "CCD_COOLER_VALUE", "cooler_power", "Cooler power", "%", 0, 100),
    _Number("CCD_BINNING", "HOR_BIN", "binning", "Binning", "", 1, primary=False, decimals=0),
    _Number("CCD_GAIN", "GAIN", "gain", "Gain", "", primary=False),
    _Number("FILTER_SLOT", "FILTER_SLOT_VALUE", "filter", "Filter", "", 0, decimals=0),
    _Number("ABS_FOCUS_POSITION", "FOCUS_ABSOLUTE_POSITION", "focus", "Focus", "", 0, decimals=0),
    _Number("FOCUS_TEMPERATURE", "TEMPERATURE", "focuser_temperature", "Focuser", "°C"),
    _Number("ABS_ROTATOR_ANGLE", "ANGLE", "angle", "Rotator angle", "°", 0, 360),
    _Number("SKY_QUALITY", "SKY_BRIGHTNESS", "sky_brightness", "Sky", "mag/arcsec²", 0, 25),
    _Number("WEATHER_PARAMETERS", "WEATHER_TEMPERATURE", "temperature", "Temperature", "°C"),
    _Number("WEATHER_PARAMETERS", "WEATHER_HUMIDITY", "humidity", "Humidity", "%", 0, 100),
    _Number("WEATHER_PARAMETERS", "WEATHER_DEWPOINT", "dew_point", "Dew point", "°C"),
    _Number("WEATHER_PARAMETERS", "WEATHER_DEW_POINT", "dew_point", "Dew point", "°C"),
    _Number("WEATHER_PARAMETERS", "WEATHER_PRESSURE", "pressure", "Pressure", "hPa"),
    _Number("WEATHER_PARAMETERS", "WEATHER_BAROMETER", "pressure", "Pressure", "hPa"),
    _Number("WEATHER_PARAMETERS", "WEATHER_WIND_SPEED", "wind", "Wind", "km/h", 0),
    _Number("WEATHER_PARAMETERS", "WEATHER_WIND_GUST", "gust", "Gust", "km/h", 0),
    _Number("WEATHER_PARAMETERS", "WEATHER_WIND_DIRECTION", "wind_from", "Wind from", "°", 0, 360),
    _Number("WEATHER_PARAMETERS", "WEATHER_RAIN_HOUR", "rain", "Rain", "mm/h", 0),
    _Number("WEATHER_PARAMETERS", "WEATHER_CLOUD_COVER", "clouds", "Clouds", "%", 0, 100),
    _Number("WEATHER_PARAMETERS", "WEATHER_FORECAST", "forecast", "Forecast", "", primary=False),
)


class _Ways(NamedTuple):
    """A standard switch that people know as one word."""

    property: str
    id: str
    name: str
    primary: bool = True


_SWITCHES = (
    _Ways("DOME_SHUTTER", "shutter", "Shutter"),
    _Ways("DOME_FLAP", "flap", "Flap"),
    _Ways("DOME_PARK", "parked", "Parking"),
    _Ways("DOME_AUTOSYNC", "follow", "Follows the telescope"),
    _Ways("TELESCOPE_PARK", "parked", "Parking"),
    _Ways("TELESCOPE_TRACK_STATE", "tracking", "Tracking"),
    _Ways("CCD_COOLER", "cooler", "Cooler"),
    _Ways("CAP_PARK", "cover", "Cover"),
    _Ways("CONNECTION", "connection", "Driver", primary=False),
)


class _Do(NamedTuple):
    """A standard command.

    Attributes:
        target: the property that must be there.
        fixed: what is set, by element or ``PROPERTY/ELEMENT``; all of it must be there.
        element: the element that the argument fills, if there is one.

    """

    target: str
    id: str
    name: str
    fixed: tuple[tuple[str, float | bool | str], ...] = ()
    element: str = ""
    argument: str = ""
    unit: str = ""
    timeout: float = 120.0
    confirm: bool = False
    description: str = ""


def _on(element: str) -> tuple[tuple[str, bool], ...]:
    return ((element, True),)


_COMMANDS = (
    _Do("DOME_SHUTTER", "open", "Open", _on("SHUTTER_OPEN"), timeout=180, confirm=True),
    _Do("DOME_SHUTTER", "close", "Close", _on("SHUTTER_CLOSE"), timeout=180),
    _Do("DOME_FLAP", "open_flap", "Open flap", _on("FLAP_OPEN"), timeout=180, confirm=True),
    _Do("DOME_FLAP", "close_flap", "Close flap", _on("FLAP_CLOSE"), timeout=180),
    _Do(
        "ABS_DOME_POSITION",
        "goto",
        "Turn to",
        element="DOME_ABSOLUTE_POSITION",
        argument="azimuth",
        unit="°",
        timeout=300,
    ),
    _Do("DOME_PARK", "park", "Park", _on("PARK"), timeout=600),
    _Do("DOME_PARK", "unpark", "Unpark", _on("UNPARK"), timeout=600, confirm=True),
    _Do("DOME_ABORT_MOTION", "stop", "Stop", _on("ABORT"), timeout=15),
    _Do("DOME_AUTOSYNC", "follow", "Follow the telescope", _on("DOME_AUTOSYNC_ENABLE"), timeout=15),
    _Do("DOME_AUTOSYNC", "unfollow", "Follow no more", _on("DOME_AUTOSYNC_DISABLE"), timeout=15),
    _Do("TELESCOPE_PARK", "park", "Park", _on("PARK"), timeout=600),
    _Do("TELESCOPE_PARK", "unpark", "Unpark", _on("UNPARK"), timeout=60, confirm=True),
    _Do("TELESCOPE_ABORT_MOTION", "stop", "Stop", _on("ABORT"), timeout=15),
    _Do("TELESCOPE_TRACK_STATE", "track", "Track", _on("TRACK_ON"), timeout=15),
    _Do("TELESCOPE_TRACK_STATE", "untrack", "Stop tracking", _on("TRACK_OFF"), timeout=15),
    _Do("CCD_ABORT_EXPOSURE", "abort", "Abort exposure", _on("ABORT"), timeout=30),
    _Do(
        "CCD_TEMPERATURE",
        "cool",
        "Cool to",
        element="CCD_TEMPERATURE_VALUE",
        argument="temperature",
        unit="°C",
        timeout=1800,
    ),
    _Do("CCD_COOLER", "cooler_on", "Cooler on", _on("COOLER_ON"), timeout=30),
    _Do("CCD_COOLER", "cooler_off", "Cooler off", _on("COOLER_OFF"), timeout=30),
    _Do("FILTER_SLOT", "filter", "Filter", element="FILTER_SLOT_VALUE", argument="slot"),
    _Do(
        "ABS_FOCUS_POSITION",
        "focus",
        "Focus to",
        element="FOCUS_ABSOLUTE_POSITION",
        argument="position",
        timeout=300,
    ),
    _Do(
        "REL_FOCUS_POSITION",
        "focus_in",
        "Focus in",
        (("FOCUS_MOTION/FOCUS_INWARD", True),),
        element="FOCUS_RELATIVE_POSITION",
        argument="steps",
        timeout=300,
    ),
    _Do(
        "REL_FOCUS_POSITION",
        "focus_out",
        "Focus out",
        (("FOCUS_MOTION/FOCUS_OUTWARD", True),),
        element="FOCUS_RELATIVE_POSITION",
        argument="steps",
        timeout=300,
    ),
    _Do("FOCUS_ABORT_MOTION", "stop_focus", "Stop focuser", _on("ABORT"), timeout=15),
    _Do(
        "ABS_ROTATOR_ANGLE",
        "rotate",
        "Rotate to",
        element="ANGLE",
        argument="angle",
        unit="°",
        timeout=300,
    ),
    _Do("ROTATOR_ABORT_MOTION", "stop_rotator", "Stop rotator", _on("ABORT"), timeout=15),
    _Do("CAP_PARK", "close_cover", "Close cover", _on("PARK")),
    _Do("CAP_PARK", "open_cover", "Open cover", _on("UNPARK")),
    _Do("WEATHER_REFRESH", "refresh", "Measure now", _on("REFRESH"), timeout=30),
    _Do("CONNECTION", "connect", "Connect driver", _on("CONNECT"), timeout=30),
    _Do(
        "CONNECTION", "disconnect", "Disconnect driver", _on("DISCONNECT"), timeout=30, confirm=True
    ),
)

# Set up once by the one who installs it: not for a page that is watched at night.
_HIDDEN_GROUPS = frozenset(
    {
        "options",
        "connection",
        "general info",
        "site management",
        "image info",
        "streaming",
        "signal processing",
        "presets",
        "wcs",
        "simulation",
        "guider head",
        "guider control",
        "alignment",
    }
)
_HIDDEN = frozenset(
    {
        "CONFIG_PROCESS",
        "DEBUG",
        "DEBUG_LEVEL",
        "LOGGING_LEVEL",
        "LOG_OUTPUT",
        "POLLING_PERIOD",
        "SIMULATION",
        "DRIVER_INFO",
        "ON_COORD_SET",
        "FITS_HEADER",
        "CCD_FRAME_TYPE",
        "CCD_FRAME_RESET",
        "TARGET_EOD_COORD",
        "TIME_UTC",
        "FOCUS_MOTION",
        "DOME_MOTION",
        "TELESCOPE_MOTION_NS",
        "TELESCOPE_MOTION_WE",
        "USEJOYSTICK",
        "FILTER_NAME",
        "WEATHER_OVERRIDE",
        "GUIDER_EXPOSURE",
        "GUIDER_ABORT_EXPOSURE",
    }
)
_IN_LABEL = re.compile(r"\(([^()]{1,12})\)\s*\Z")
_UNITS = {
    "c": "°C",
    "°c": "°C",
    "kph": "km/h",
    "km/h": "km/h",
    "m/s": "m/s",
    "mm": "mm",
    "mm/h": "mm/h",
    "deg": "°",
    "s": "s",
    "sec": "s",
    "ms": "ms",
    "%": "%",
    "hpa": "hPa",
    "mb": "hPa",
    "m": "m",
    "v": "V",
    "a": "A",
    "w": "W",
    "um": "",
    "arcsecs/s": "",
    "hh:mm:ss": "h",
    "dd:mm:ss": "°",
}
_KINDS = (
    (Interface.DOME, DeviceKind.DOME),
    (Interface.TELESCOPE, DeviceKind.TELESCOPE),
    (Interface.CCD, DeviceKind.CAMERA),
    (Interface.WEATHER, DeviceKind.WEATHER),
)


def word_of(name: str, taken: Iterable[str] = (), otherwise: str = "indi") -> str:
    """Make a word for an address of any name, other than those that are taken."""
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode().lower()
    word = re.sub(r"[^a-z0-9]+", "_", plain).strip("_")[:50]
    if not word or not word[0].isalpha():
        word = f"{otherwise}_{word}".rstrip("_")
    used, unique, count = set(taken), word, 2
    while unique in used:
        unique, count = f"{word}_{count}", count + 1
    return unique


def devices_of(
    found: Iterable[IndiDevice], connection: str, taken: Iterable[str] = ()
) -> dict[str, Device]:
    """Describe devices by id; their ids keep clear of those that are ``taken``.

    A name that cannot be written in a description (too long, unseen characters) is left out.
    """
    made: dict[str, Device] = {}
    for device in found:
        if not _fits(device.name):
            continue
        device_id = word_of(device.name, {*taken, *made}, "device")
        made[device_id] = Device(
            name=_shown(device.name),
            kind=_kind(device.interface),
            connection=connection,
            indi=device.name,
            signals=_signals(device),
            commands=_commands(device),
        )
    return made


def _kind(bits: int) -> DeviceKind:
    return next((kind for bit, kind in _KINDS if bits & bit), DeviceKind.OTHER)


def _fits(word: str) -> bool:
    return 0 < len(word) <= _MAX_WORD and word.isprintable() and bool(word.strip())


def _shown(name: str) -> str:
    seen = "".join(letter if letter.isprintable() else " " for letter in name)
    return " ".join(seen.split())[:100] or "unnamed"


# ── signals ──


def _signals(device: IndiDevice) -> dict[str, Signal]:
    made: dict[str, Signal] = {}
    known: set[str] = set()
    weather = device.vectors.get("WEATHER_STATUS")
    max_age = _weather_age(device)
    if weather is not None:
        known.add("WEATHER_STATUS")
        made["safety"] = Signal(
            name="Safety",
            source=IndiSource(property="WEATHER_STATUS"),
            type=SignalType.STATE,
            # In the order of Idle, Ok, Busy, Alert.
            states=("unknown", "safe", "warning", "unsafe"),
            max_age=max_age,
        )
    for ways in _SWITCHES:
        if ways.property in device.vectors:
            known.add(ways.property)
            made[word_of(ways.id, made)] = Signal(
                name=ways.name,
                source=IndiSource(property=ways.property),
                type=SignalType.STATE,
                states=moving_words(ways.property),
                primary=ways.primary,
            )
    for row in _NUMBERS:
        held = device.vectors.get(row.property)
        element = None if held is None else held.elements.get(row.element)
        if held is None or element is None or row.id in made:
            continue
        known.add(row.property)
        made[row.id] = _standard(device, row, element, max_age)
    for held in device.vectors.values():
        if len(made) >= MAX_SIGNALS:
            break
        shown = held.name == "WEATHER_PARAMETERS" or held.name not in known
        if shown and _is_shown(held, device):
            _add_generic(made, held, max_age)
    made["message"] = Signal(
        name="Message",
        source=IndiSource(property=MESSAGE),
        type=SignalType.TEXT,
        primary=False,
    )
    return made


def _weather_age(device: IndiDevice) -> float:
    """Two and a half of the driver's own periods (s)."""
    period = device.value("WEATHER_UPDATE", "PERIOD")
    return 2.5 * period if isinstance(period, float) and 0 < period <= 3600 else 150.0


def _standard(device: IndiDevice, row: _Number, element: Element, max_age: float) -> Signal:
    unit = row.unit
    if row.property == "WEATHER_PARAMETERS":
        # The driver's label says what it really measures in, except that rain is by the hour.
        own = _unit(element.label)
        unit = own if own and row.id != "rain" else unit
    source = IndiSource(property=row.property, element=row.element)
    names = _filters(device) if row.property == "FILTER_SLOT" else ()
    if names:
        # Slots count from one.
        return Signal(name=row.name, source=source, type=SignalType.STATE, states=("–", *names))
    return Signal(
        name=row.name,
        source=source,
        unit=unit,
        minimum=row.low,
        maximum=row.high,
        decimals=row.decimals,
        max_age=max_age if row.property == "WEATHER_PARAMETERS" else 5.0,
        primary=row.primary,
    )


def _filters(device: IndiDevice) -> tuple[str, ...]:
    held = device.vectors.get("FILTER_NAME")
    if held is None:
        return ()
    names = [_shown(str(element.value)) for element in held.elements.values()][:50]
    return tuple(
        name if names.count(name) == 1 else f"{name} {at}" for at, name in enumerate(names, 1)
    )


def _is_shown(held: StoredVector, device: IndiDevice) -> bool:
    if held.name in _HIDDEN or held.kind is VectorKind.BLOB or not _fits(held.name):
        return False
    if device.interface == 0:
        return held.group.lower() != "connection"
    if held.group == "Parameters":  # weather: limits of the driver, beside the values
        return held.name == "WEATHER_PARAMETERS"
    return held.group.lower() not in _HIDDEN_GROUPS


def _add_generic(made: dict[str, Signal], held: StoredVector, max_age: float) -> None:
    title = _shown(held.label or held.name)
    sources = {
        (signal.source.property, signal.source.element)
        for signal in made.values()
        if isinstance(signal.source, IndiSource)
    }
    if held.kind is VectorKind.SWITCH and held.rule is not SwitchRule.ANY:
        if len(held.elements) < 2:
            return
        states = _states(held)
        made[word_of(held.name, made)] = Signal(
            name=title,
            source=IndiSource(property=held.name),
            type=SignalType.STATE,
            states=states,
            primary=False,
        )
        return
    for element in held.elements.values():
        if len(made) >= MAX_SIGNALS or not _fits(element.name):
            return
        if (held.name, element.name) in sources:
            continue
        single = len(held.elements) == 1
        label = _shown(_IN_LABEL.sub("", element.label) or element.name)
        signal = Signal(
            name=(title if single else f"{title}: {label}")[:100],
            source=IndiSource(property=held.name, element=element.name),
            primary=False,
            max_age=max_age if held.name == "WEATHER_PARAMETERS" else 5.0,
        )
        word = word_of(held.name if single else f"{held.name}_{element.name}", made)
        made[word] = _typed(signal, held, element)


def _states(held: StoredVector) -> tuple[str, ...]:
    labels = [_shown(element.label or element.name) for element in held.elements.values()]
    unique = tuple(
        label if labels.count(label) == 1 else _shown(element.name)
        for label, element in zip(labels, held.elements.values(), strict=True)
    )
    return (*unique, "none") if held.rule is SwitchRule.AT_MOST_ONE else unique


def _typed(signal: Signal, held: StoredVector, element: Element) -> Signal:
    match held.kind:
        case VectorKind.TEXT:
            return _changed(signal, type=SignalType.TEXT)
        case VectorKind.LIGHT:
            return _changed(signal, type=SignalType.STATE, states=("idle", "ok", "busy", "alert"))
        case VectorKind.SWITCH:
            return _changed(signal, type=SignalType.STATE, states=("off", "on"))
        case _:
            return _changed(signal, unit=_unit(element.label))


def _changed(signal: Signal, **values: object) -> Signal:
    fields = {name: getattr(signal, name) for name in signal.__struct_fields__}
    return Signal(**{**fields, **values})


def _unit(label: str) -> str:
    match = _IN_LABEL.search(label)
    return "" if match is None else _UNITS.get(match[1].strip().lower(), "")


# ── commands ──


def _commands(device: IndiDevice) -> dict[str, Command]:
    made: dict[str, Command] = {}
    known: set[str] = {row.target for row in _COMMANDS}
    if "EQUATORIAL_EOD_COORD" in device.vectors:
        made |= _pointing(device)
    if "CCD_EXPOSURE" in device.vectors:
        made["expose"] = _expose(device)
    known |= {"EQUATORIAL_EOD_COORD", "CCD_EXPOSURE"}
    for row in _COMMANDS:
        held = device.vectors.get(row.target)
        if held is not None and held.perm is not PropertyPermission.READ and _has(device, row):
            made[word_of(row.id, made)] = _command(held, row)
    for held in device.vectors.values():
        if len(made) >= MAX_COMMANDS:
            break
        if (
            held.perm is not PropertyPermission.READ
            and held.name not in known
            and _is_shown(held, device)
        ):
            _add_setting(made, held)
    return made


def _has(device: IndiDevice, row: _Do) -> bool:
    wanted = [name for name, _ in row.fixed] + ([row.element] if row.element else [])
    for field in wanted:
        before, _, element = field.rpartition("/")
        if device.value(before or row.target, element) is None:
            return False
    return True


def _command(held: StoredVector, row: _Do) -> Command:
    arguments = {}
    if row.element:
        element = held.elements[row.element]
        arguments[row.argument] = _number_argument(element, row.argument.capitalize(), row.unit)
    return Command(
        name=row.name,
        kind=CommandKind.INDI,
        target=row.target,
        fixed=dict(row.fixed),
        arguments=arguments,
        timeout=row.timeout,
        confirm=row.confirm,
        description=row.description,
    )


def _number_argument(element: Element, name: str, unit: str) -> Argument:
    limited = element.minimum < element.maximum
    return Argument(
        type=ArgumentType.NUMBER,
        field=element.name,
        name=name,
        unit=unit,
        minimum=element.minimum if limited else None,
        maximum=element.maximum if limited else None,
    )


def _pointing(device: IndiDevice) -> dict[str, Command]:
    arguments = {
        "ra": Argument(
            type=ArgumentType.NUMBER,
            field="RA",
            name="Right ascension (JNow)",
            unit="h",
            minimum=0.0,
            maximum=24.0,
        ),
        "dec": Argument(
            type=ArgumentType.NUMBER,
            field="DEC",
            name="Declination (JNow)",
            unit="°",
            minimum=-90.0,
            maximum=90.0,
        ),
    }
    made = {}
    for element, word, name, timeout in (
        ("TRACK", "goto", "Go to", 600.0),
        ("SYNC", "sync", "Sync", 15.0),
    ):
        if device.value("ON_COORD_SET", element) is None:
            continue
        made[word] = Command(
            name=name,
            kind=CommandKind.INDI,
            target="EQUATORIAL_EOD_COORD",
            fixed={f"ON_COORD_SET/{element}": True},
            arguments=arguments,
            timeout=timeout,
            confirm=element == "SYNC",
            description="" if element == "TRACK" else "The telescope points there now.",
        )
    return made


def _expose(device: IndiDevice) -> Command:
    element = device.vectors["CCD_EXPOSURE"].elements.get("CCD_EXPOSURE_VALUE")
    longest = element.maximum if element is not None and element.maximum > 0 else 3600.0
    arguments = {
        "seconds": Argument(
            type=ArgumentType.NUMBER,
            field="CCD_EXPOSURE_VALUE",
            name="Exposure",
            unit="s",
            minimum=max(0.0, element.minimum) if element is not None else 0.0,
            maximum=longest,
        )
    }
    if "CCD_FRAME_TYPE" in device.vectors:
        arguments["frame"] = Argument(
            type=ArgumentType.TEXT,
            field=f"CCD_FRAME_TYPE/{CHOICE}",
            name="Frame",
            default="Light",
            max_length=20,
        )
    if device.value("FITS_HEADER", "FITS_OBJECT") is not None:
        arguments["target"] = Argument(
            type=ArgumentType.TEXT,
            field="FITS_HEADER/FITS_OBJECT",
            name="Target",
            default="Unknown",
            max_length=60,
        )
    return Command(
        name="Expose",
        kind=CommandKind.INDI,
        target="CCD_EXPOSURE",
        arguments=arguments,
        # From one word of the driver to the next: it counts down each second, then reads out.
        timeout=120.0,
    )


def _add_setting(made: dict[str, Command], held: StoredVector) -> None:
    """Let any other property be set by its own labels."""
    title = _shown(held.label or held.name)
    elements = [element for element in held.elements.values() if _fits(element.name)]
    if (
        held.kind is VectorKind.SWITCH
        and len(held.elements) == 1
        and held.rule is not SwitchRule.ANY
    ):
        made[word_of(held.name, made)] = Command(
            name=title,
            kind=CommandKind.INDI,
            target=held.name,
            fixed={elements[0].name: True} if elements else {},
        )
        return
    arguments: dict[str, Argument] = {}
    if held.kind is VectorKind.SWITCH and held.rule is not SwitchRule.ANY:
        words = ", ".join(_shown(element.label or element.name) for element in elements)
        arguments["choice"] = Argument(
            type=ArgumentType.TEXT, field=CHOICE, name=f"One of {words}"[:100], max_length=64
        )
    else:
        for element in elements[:12]:
            name = _shown(_IN_LABEL.sub("", element.label) or element.name)
            word = word_of(name, arguments, "value")
            if held.kind is VectorKind.NUMBER:
                arguments[word] = _number_argument(element, name, _unit(element.label))
            else:
                boolean = held.kind is VectorKind.SWITCH
                arguments[word] = Argument(
                    type=ArgumentType.BOOLEAN if boolean else ArgumentType.TEXT,
                    field=element.name,
                    name=name,
                )
    if arguments:
        made[word_of(f"set_{held.name}", made)] = Command(
            name=f"Set {title}"[:100],
            kind=CommandKind.INDI,
            target=held.name,
            arguments=arguments,
        )
