"""Names as people say what drivers write: ``fl wheel`` Front left wheel, ``mcu`` MCU. Pure.

Only what is shown; the words of addresses stay as they are.
"""

from __future__ import annotations

import re

from talaia.model.discovery.ros_units import unit_said, without_unit

__all__ = ["spoken_name"]

# Said letter by letter.
_LETTERS = {
    *("adc", "ahrs", "amcl", "bms", "can", "cctv", "cpu", "dac", "dvl", "ekf", "esc", "fcu", "fmu"),
    *("gnss", "gpio", "gps", "gpu", "hmi", "http", "imu", "ins", "ip", "ir", "json", "led", "mac"),
    *("mcu", "nmea", "pcb", "pdu", "pid", "plc", "ptz", "pto", "pwm", "ram", "rc", "rgb", "rov"),
    *("rssi", "rtcm", "rtk", "ssd", "ssid", "tcp", "tof", "udid", "udp", "uri", "url", "ups"),
    *("usb", "usv", "uuid", "uwb", "vesc", "vtol", "utm", "pps"),
}
# Words of drivers, and what people call it; the longer ones first. In small letters within a name.
_PHRASES = (
    ("e stop", "emergency stop"),
    ("estop", "emergency stop"),
    ("emergency stop state", "emergency stop"),
    ("cmd vel", "velocity command"),
    ("joint states", "joints"),
    ("high bat temp", "high battery temperature"),
    ("bat temp", "battery temperature"),
    ("raspberry pi", "Raspberry Pi"),
    ("two d", "2D"),
    ("nav 2", "Nav2"),
    ("ros 2", "ROS 2"),
    ("moveit", "MoveIt"),
    ("wifi", "Wi-Fi"),
    ("ft wrench", "force-torque"),
    ("odom", "odometry"),
    ("vel", "velocity"),
    ("temp", "temperature"),
    ("lidar 2 d", "2D lidar"),
    ("avg", "average"),
    ("num", "number of"),
    ("io", "I/O"),
)
_PLACES = {"fl": "front left", "fr": "front right", "rl": "rear left", "rr": "rear right"} | {
    f"{end}{side}": f"{end} {side}"
    for end in ("front", "rear", "back")
    for side in ("left", "right")
}
# What a whole name means that is short for something.
_WHOLE = {
    "ra": "Right ascension",
    "dec": "Declination",
    "axis ra": "Axis of right ascension",
    "axis dec": "Axis of declination",
    "getcoord": "Get coordinates",
    "allsky": "All-sky",
}
# Two letters are a corner of a robot where a part of one follows, and else anything.
_PARTS = r"(?:wheels?|motors?|hip|knee|leg|foot|feet|ankle|caster|drive|steering|esc|thruster)"
_CORNER = re.compile(rf"\b(fl|fr|rl|rr)(?= {_PARTS}\b)", re.IGNORECASE)
_SIDE = re.compile(r"\b(front|rear|back)(left|right)\b", re.IGNORECASE)
# A robot's own name: ``fr3``, ``cf1``; not the first of several inputs.
_MODEL = re.compile(
    r"\A(?!in |on |up |to |no |io |ir |ac |dc |rc )([a-z]{2}) (\d)(?=\s)", re.IGNORECASE
)
_TWICE = re.compile(r"\b(\w{3,})( \1)+\b", re.IGNORECASE)
_RULES = tuple((re.compile(rf"\b{said}\b", re.IGNORECASE), plain) for said, plain in _PHRASES)
_ABBREVIATION = re.compile(rf"\b({'|'.join(sorted(_LETTERS, key=len, reverse=True))})\b(?!-)")


def spoken_name(name: str, unit: str = "") -> str:
    """Say a name of a robot's own as people do.

    Args:
        name: as it was made of a topic, a field or a parameter: ``Timeout s``.
        unit: what is told beside it, and need not be said in it.

    """
    # What is written by people, or leads somewhere, is theirs: `/safety/water`, `lidar2d_0`.
    if any(sign in name for sign in "/_:"):
        return name
    if whole := _WHOLE.get(name.lower()):
        return whole
    said = without_unit(name).replace("_", " ") if unit and _says_unit(name, unit) else name
    # Before the phrases: of these one may be the name of a model.
    said = _MODEL.sub(lambda found: f"{found[1].upper()}{found[2]}", said)
    said = _CORNER.sub(lambda found: _PLACES[found[1].lower()], said)
    said = _SIDE.sub(lambda found: f"{found[1]} {found[2].lower()}", said)
    for rule, plain in _RULES:
        said = rule.sub(plain, said)
    said = _TWICE.sub(lambda found: found[1], said)
    # Also where it begins the name: ``Mcu temperature``.
    first, _, rest = said.partition(" ")
    said = f"{first.upper()} {rest}".strip() if first.lower() in _LETTERS else said
    said = _ABBREVIATION.sub(lambda found: found[1].upper(), said)
    return said[:1].upper() + said[1:]


def _says_unit(name: str, unit: str) -> bool:
    meaning = unit_said(name)
    return meaning is not None and meaning.unit == unit
