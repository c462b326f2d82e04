"""What the fields of ROS messages mean: units by REP-103 and the definitions, names people read.

The tables hold what the message definitions say in comments, which no running program can ask
for. For types that are not in them, the words of a field's name and of its comment are read.
Long, because its tables are.
"""

from __future__ import annotations

import re
import unicodedata
from itertools import pairwise
from typing import NamedTuple

from talaia.model.units.unit import UNITS

__all__ = [
    "NO_WORD",
    "Meaning",
    "meaning_of",
    "readable_name",
    "unit_in_comment",
    "unit_in_name",
    "unit_said",
    "without_unit",
    "word_of",
]


class Meaning(NamedTuple):
    """A unit, and what the robot's number is multiplied by to be in it."""

    unit: str
    scale: float = 1.0


# ROS gives these as 0 to 1.
_PERCENT = Meaning("%", 100.0)
# By the message type (without /msg/) and the field in it; it holds for all that lies below.
_KNOWN: dict[tuple[str, str], Meaning] = {
    ("geometry_msgs/Twist", "linear"): Meaning("m/s"),
    ("geometry_msgs/Twist", "angular"): Meaning("rad/s"),
    ("geometry_msgs/Accel", "linear"): Meaning("m/s²"),
    ("geometry_msgs/Pose", "position"): Meaning("m"),
    ("geometry_msgs/Transform", "translation"): Meaning("m"),
    ("geometry_msgs/Wrench", "force"): Meaning("N"),
    ("geometry_msgs/Wrench", "torque"): Meaning("N·m"),
    ("geometry_msgs/PointStamped", "point"): Meaning("m"),
    ("geometry_msgs/Pose2D", "x"): Meaning("m"),
    ("geometry_msgs/Pose2D", "y"): Meaning("m"),
    ("geometry_msgs/Pose2D", "theta"): Meaning("rad"),
    ("geometry_msgs/Inertia", "m"): Meaning("kg"),
    ("sensor_msgs/Imu", "angular_velocity"): Meaning("rad/s"),
    ("sensor_msgs/Imu", "linear_acceleration"): Meaning("m/s²"),
    ("sensor_msgs/MagneticField", "magnetic_field"): Meaning("T"),
    ("sensor_msgs/Temperature", "temperature"): Meaning("°C"),
    ("sensor_msgs/FluidPressure", "fluid_pressure"): Meaning("Pa"),
    ("sensor_msgs/RelativeHumidity", "relative_humidity"): _PERCENT,
    ("sensor_msgs/Illuminance", "illuminance"): Meaning("lx"),
    ("sensor_msgs/Range", "range"): Meaning("m"),
    ("sensor_msgs/Range", "min_range"): Meaning("m"),
    ("sensor_msgs/Range", "max_range"): Meaning("m"),
    ("sensor_msgs/Range", "field_of_view"): Meaning("rad"),
    ("sensor_msgs/BatteryState", "voltage"): Meaning("V"),
    ("sensor_msgs/BatteryState", "temperature"): Meaning("°C"),
    ("sensor_msgs/BatteryState", "current"): Meaning("A"),
    ("sensor_msgs/BatteryState", "charge"): Meaning("Ah"),
    ("sensor_msgs/BatteryState", "capacity"): Meaning("Ah"),
    ("sensor_msgs/BatteryState", "design_capacity"): Meaning("Ah"),
    ("sensor_msgs/BatteryState", "percentage"): _PERCENT,
    ("sensor_msgs/BatteryState", "cell_voltage"): Meaning("V"),
    ("sensor_msgs/BatteryState", "cell_temperature"): Meaning("°C"),
    ("sensor_msgs/NavSatFix", "latitude"): Meaning("°"),
    ("sensor_msgs/NavSatFix", "longitude"): Meaning("°"),
    ("sensor_msgs/NavSatFix", "altitude"): Meaning("m"),
    ("px4_msgs/SensorCombined", "gyro_rad"): Meaning("rad/s"),
    ("px4_msgs/SensorCombined", "gyro_integral_dt"): Meaning("µs"),
    ("mavros_msgs/VfrHud", "heading"): Meaning("°"),
    ("mavros_msgs/VfrHud", "throttle"): _PERCENT,
    ("mavros_msgs/Altitude", "monotonic"): Meaning("m"),
    ("mavros_msgs/Altitude", "local"): Meaning("m"),
    ("mavros_msgs/Altitude", "relative"): Meaning("m"),
    ("mavros_msgs/Altitude", "terrain"): Meaning("m"),
    ("mavros_msgs/Altitude", "bottom_clearance"): Meaning("m"),
    ("px4_msgs/VehicleOdometry", "position"): Meaning("m"),
    ("px4_msgs/VehicleOdometry", "velocity"): Meaning("m/s"),
    ("px4_msgs/VehicleOdometry", "angular_velocity"): Meaning("rad/s"),
    ("px4_msgs/BatteryStatus", "remaining"): _PERCENT,
    ("px4_msgs/VehicleLocalPosition", "heading"): Meaning("rad"),
    ("ackermann_msgs/AckermannDrive", "speed"): Meaning("m/s"),
    ("ackermann_msgs/AckermannDrive", "steering_angle"): Meaning("rad"),
    ("sensor_msgs/LaserScan", "angle_min"): Meaning("rad"),
    ("sensor_msgs/LaserScan", "angle_max"): Meaning("rad"),
    ("sensor_msgs/LaserScan", "angle_increment"): Meaning("rad"),
    ("sensor_msgs/LaserScan", "time_increment"): Meaning("s"),
    ("sensor_msgs/LaserScan", "scan_time"): Meaning("s"),
    ("sensor_msgs/LaserScan", "range_min"): Meaning("m"),
    ("sensor_msgs/LaserScan", "range_max"): Meaning("m"),
    ("sensor_msgs/LaserScan", "ranges"): Meaning("m"),
}
# The last word of a field's name, as robots' own messages write units.
_SUFFIX: dict[str, Meaning] = {
    "m": Meaning("m"),
    "meters": Meaning("m"),
    "metres": Meaning("m"),
    "cm": Meaning("cm"),
    "mm": Meaning("mm"),
    "km": Meaning("km"),
    "mps": Meaning("m/s"),
    "kmh": Meaning("km/h"),
    "kph": Meaning("km/h"),
    "rad": Meaning("rad"),
    "radians": Meaning("rad"),
    "deg": Meaning("°"),
    "degrees": Meaning("°"),
    "hz": Meaning("Hz"),
    "rpm": Meaning("rpm"),
    "v": Meaning("V"),
    "volts": Meaning("V"),
    "mv": Meaning("mV"),
    "amps": Meaning("A"),
    "watts": Meaning("W"),
    "wh": Meaning("Wh"),
    "ah": Meaning("Ah"),
    "celsius": Meaning("°C"),
    "degc": Meaning("°C"),
    "kelvin": Meaning("K"),
    "pa": Meaning("Pa"),
    "hpa": Meaning("hPa"),
    "lux": Meaning("lx"),
    "pct": Meaning("%"),
    "percent": Meaning("%"),
    "percentage": Meaning("%"),
    "sec": Meaning("s"),
    "secs": Meaning("s"),
    "seconds": Meaning("s"),
    "ms": Meaning("ms"),
    "minutes": Meaning("min"),
    "ppm": Meaning("ppm"),
    "ppb": Meaning("ppb"),
    "dbm": Meaning("dBm"),
    "db": Meaning("dB"),
    "kg": Meaning("kg"),
    "bar": Meaning("bar"),
    "mbar": Meaning("mbar"),
    "psi": Meaning("psi"),
    "kpa": Meaning("kPa"),
    "ma": Meaning("mA"),
    "mah": Meaning("mAh"),
    "kw": Meaning("kW"),
    "kwh": Meaning("kWh"),
    "us": Meaning("µs"),
    "lpm": Meaning("L/min"),
    "lph": Meaning("L/h"),
    "dps": Meaning("°/s"),
    "kn": Meaning("kn"),
    "knots": Meaning("kn"),
    "kts": Meaning("kn"),
}
# Single letters, which are units only after the word that they measure: ``temp_c``.
_AFTER: dict[tuple[str, str], Meaning] = {
    **{(word, "c"): Meaning("°C") for word in ("temp", "temperature")},
    **{(word, "f"): Meaning("°F") for word in ("temp", "temperature")},
    **{(word, "a"): Meaning("A") for word in ("current", "amperage")},
    ("current", "ma"): Meaning("mA"),
    ("power", "w"): Meaning("W"),
    ("torque", "nm"): Meaning("N·m"),
    **{(word, "l"): Meaning("L") for word in ("level", "volume", "fuel")},
    ("force", "n"): Meaning("N"),
    **{
        (word, "s"): Meaning("s")
        for word in ("age", "delay", "duration", "interval", "period", "time", "timeout")
    },
}
# Units of two words and more at the end of a name.
_ENDINGS: tuple[tuple[tuple[str, ...], Meaning], ...] = (
    (("m", "s", "2"), Meaning("m/s²")),
    (("m", "s2"), Meaning("m/s²")),
    (("m", "s"), Meaning("m/s")),
    (("rad", "s"), Meaning("rad/s")),
    (("deg", "s"), Meaning("°/s")),
    (("km", "h"), Meaning("km/h")),
)
# Words that REP-103 gives one unit: SI, and degrees Celsius for temperatures.
_QUANTITY: dict[str, Meaning] = {
    "voltage": Meaning("V"),
    "temperature": Meaning("°C"),
    "temp": Meaning("°C"),
    "illuminance": Meaning("lx"),
    "rssi": Meaning("dBm"),
    "rpm": Meaning("rpm"),
    "ppm": Meaning("ppm"),
    "voltages": Meaning("V"),
    "temperatures": Meaning("°C"),
    "frequency": Meaning("Hz"),
    "current": Meaning("A"),
    "currents": Meaning("A"),
    "torque": Meaning("N·m"),
    "altitude": Meaning("m"),
    "alt": Meaning("m"),
    "amsl": Meaning("m"),
    "depth": Meaning("m"),
    "distance": Meaning("m"),
    "groundspeed": Meaning("m/s"),
    "airspeed": Meaning("m/s"),
    "climb": Meaning("m/s"),
    "accelerometer": Meaning("m/s²"),
    "gyro": Meaning("rad/s"),
    "latitude": Meaning("°"),
    "longitude": Meaning("°"),
    "lat": Meaning("°"),
    "lon": Meaning("°"),
    "hdg": Meaning("°"),
}
# Quantities that stand before what they are of.
_FIRST = ("voltage", "temperature", "temp")
_OF_CURRENT = ("motor", "input", "output", "battery", "left", "right", "in", "out", "draw")
# Of whole numbers these are steps of a converter, or thousandths.
_RAW = [_QUANTITY[word] for word in ("voltage", "current", "torque", "altitude", "latitude")]
# As definitions' comments spell them, in small letters.
_SPOKEN: dict[str, str] = {
    "meter": "m",
    "meters": "m",
    "metre": "m",
    "metres": "m",
    "meters per second": "m/s",
    "metres per second": "m/s",
    "radian": "rad",
    "radians": "rad",
    "radians per second": "rad/s",
    "rad/sec": "rad/s",
    "m/sec": "m/s",
    "degrees": "°",
    "degree": "°",
    "deg": "°",
    "degrees celsius": "°C",
    "celsius": "°C",
    "kelvin": "K",
    "volt": "V",
    "volts": "V",
    "ampere": "A",
    "amperes": "A",
    "amps": "A",
    "watts": "W",
    "hertz": "Hz",
    "percent": "%",
    "second": "s",
    "seconds": "s",
    "milliseconds": "ms",
    "pascal": "Pa",
    "pascals": "Pa",
    "lux": "lx",
    "newton": "N",
    "newtons": "N",
    "tesla": "T",
    "kilograms": "kg",
    "m/s^2": "m/s²",
    # In newton metres, not in nanometres.
    "nm": "N·m",
}
# Symbols that mean something else in brackets: (in), accelerations in [g], (t).
_WORDS = frozenset({"in", "d", "g", "t", "lb", "bit"})
# ``[m/s]`` or ``(rad)``; bounded, since brackets in comments hold whole sentences, too.
_BRACKETS = re.compile(r"[\[(]\s*([^\])]{1,30}?)\s*[\])]")
_IN = re.compile(r"\bin\s+(degrees celsius|[a-zA-Z/]+(?: per second)?)", re.IGNORECASE)
# Words of ``motorLeft_GPS2``: motor, Left, GPS, 2.
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_NOT_A_LETTER = re.compile(r"[^a-z0-9]+")
_MAX_WORD = 63
# Of a text with no letter or digit that can be one of an address.
NO_WORD = "unnamed"


def meaning_of(type_name: str, field: str) -> Meaning | None:
    """Tell what the definition of a common message says of a field; none if it is not known.

    ``type_name`` is ``package/Name``.
    """
    return _KNOWN.get((type_name, field))


def unit_in_name(field: str, *, whole: bool = False) -> Meaning | None:
    """Read the unit from the last word of a field's own name: ``wheel_speed_mps``.

    Args:
        field: its name.
        whole: it holds whole numbers, which are of a board's own scale where a name says no unit.

    """
    said = unit_said(field)
    if said is not None:
        return said
    words = [word.lower() for word in _WORD.findall(field)]
    if not words:
        return None
    if whole and words[-1] in ("percent", "percentage"):
        # Of parts of one there are no whole numbers.
        return Meaning("%")
    found = _QUANTITY.get(words[-1])
    if found is None and len(words) > 1:
        # `voltage_input`, `temp_fet`; but a `current_mode` is no ampere.
        first = words[0] in _FIRST or (words[0] == "current" and words[1] in _OF_CURRENT)
        found = _QUANTITY.get(words[0]) if first else None
    return None if whole and found in _RAW else found


def unit_said(field: str) -> Meaning | None:
    """Read the unit that a name says itself at its end: ``timeout_sec``, not ``voltage``."""
    words = [word.lower() for word in _WORD.findall(field)]
    if len(words) > 2:
        for ending, meaning in _ENDINGS:
            if tuple(words[-len(ending) :]) == ending and len(words) > len(ending):
                return meaning
    for pair in pairwise(words):
        # Also before a side: ``current_ma_left``.
        if pair in _AFTER:
            return _AFTER[pair]
    # A unit needs something before it: a field that is called ``m`` or ``v`` may be anything.
    if len(words) > 1 and words[-1] in _SUFFIX:
        return _SUFFIX[words[-1]]
    return None


def without_unit(field: str) -> str:
    """Take the unit off the end of a field's name: ``motor_temp_c`` gives motor_temp."""
    words = _WORD.findall(field)
    lower = [word.lower() for word in words]
    for index, pair in enumerate(pairwise(lower)):
        if pair in _AFTER:
            return "_".join([*words[: index + 1], *words[index + 2 :]])
    for ending, _ in _ENDINGS:
        if len(words) > len(ending) and tuple(lower[-len(ending) :]) == ending:
            return "_".join(words[: -len(ending)])
    if len(words) > 1 and lower[-1] == "rpm":
        # Speed is what people call it.
        return "_".join([*words[:-1], "speed"])
    if len(words) > 1 and lower[-1] in _SUFFIX and lower[-1] != "percentage":
        return "_".join(words[:-1])
    return field


def unit_in_comment(comment: str) -> Meaning | None:
    """Read the unit from a definition's comment: ``speed over ground [m/s]``, ``in metres``."""
    spoken = [*_BRACKETS.findall(comment), *_IN.findall(comment)]
    for unit in spoken:
        symbol = _SPOKEN.get(unit.lower()) or (unit if unit in UNITS.keys() - _WORDS else "")
        if symbol:
            return Meaning(symbol)
    return None


def readable_name(text: str) -> str:
    """Make a name people read of a field: ``motorLeft_temp`` gives Motor left temp."""
    # Capitals are an abbreviation (GPS, IMU) and stay; one capital only begins a word.
    words = [
        word if word.isupper() and len(word) > 1 else word.lower() for word in _WORD.findall(text)
    ]
    joined = " ".join(words)
    return joined[:1].upper() + joined[1:]


def word_of(text: str) -> str:
    """Make a word of an address of any text: small letters, digits and _; never empty."""
    # Letters without their accents, and CO₂ with its 2.
    plain = "".join(
        letter
        for letter in unicodedata.normalize("NFKD", text)
        if not unicodedata.combining(letter)
    )
    spread = "_".join(_WORD.findall(plain)).lower()
    word = _NOT_A_LETTER.sub("_", spread).strip("_")[:_MAX_WORD].rstrip("_")
    if not word:
        return NO_WORD
    # A word of an address begins with a letter.
    return word if word[0].isalpha() else f"n{word}"[:_MAX_WORD]
