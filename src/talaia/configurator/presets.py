"""The sensors that people choose from a list: their word, unit and usual range.

The word with a number behind it (``temperature1``) is what the founding vehicle's nodes call the
sensor on ``/metric``.
"""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["OTHERS", "SENSORS", "SensorKind"]


class SensorKind(NamedTuple):
    """One kind of sensor.

    Attributes:
        word: of its address.
        name: what people call it.
        unit: a symbol of `model.units.unit`.
        minimum: lowest value that makes sense, in ``unit``; none where it depends.
        maximum: highest value that makes sense.

    """

    word: str
    name: str
    unit: str
    minimum: float | None = None
    maximum: float | None = None


SENSORS = (
    SensorKind("temperature", "Temperature", "°C"),
    SensorKind("humidity", "Humidity", "%", 0.0, 100.0),
    SensorKind("voltage", "Voltage", "V"),
    SensorKind("current", "Current", "A"),
    SensorKind("power", "Power", "W"),
    SensorKind("charge", "Battery charge", "%", 0.0, 100.0),
    SensorKind("distance", "Distance", "m", 0.0),
    SensorKind("ultrasonic", "Ultrasonic", "m", 0.0),
    SensorKind("speed", "Speed", "m/s"),
    SensorKind("turn_rate", "Turn rate", "rad/s"),
    SensorKind("acceleration", "Acceleration", "m/s²"),
    SensorKind("angle", "Angle", "°"),
    SensorKind("pressure", "Air pressure", "hPa"),
    SensorKind("light", "Illuminance", "lx", 0.0),
    SensorKind("gas", "Gas concentration", "ppm", 0.0),
    SensorKind("sound", "Sound level", "dB"),
    SensorKind("wind", "Wind speed", "m/s", 0.0),
    SensorKind("rain", "Rain rate", "mm/h", 0.0),
    SensorKind("sky", "Sky brightness", "mag/arcsec²"),
    SensorKind("rpm", "Rotation", "rpm"),
    SensorKind("force", "Force", "N"),
    SensorKind("torque", "Torque", "N·m"),
    SensorKind("weight", "Weight", "kg", 0.0),
    SensorKind("field", "Magnetic field", "T"),
    SensorKind("frequency", "Frequency", "Hz", 0.0),
    SensorKind("signal_strength", "Signal strength", "dBm"),
)
# With a name and a unit that the person writes.
OTHERS = SensorKind("", "Others", "")
