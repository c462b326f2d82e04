"""What the standard properties mean: words for switches, and which clock makes a value fresh. Pure.

INDI says a shutter by two switches and a state: which of the two was asked for last, and whether
it still moves. People and interlocks want one word.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.adapters.indi.protocol import PropertyState, VectorKind
from talaia.gateway.samples.source_stamps import iso_stamp_ns

if TYPE_CHECKING:
    from talaia.gateway.adapters.indi.state import IndiDevice, IndiDeviceTree, StoredVector

__all__ = [
    "LIGHTS",
    "MESSAGE",
    "DriverTimestamp",
    "PropertyReading",
    "moving_words",
    "read_number",
    "read_state",
    "read_text",
    "stamp_of",
]

# A property that no driver has: the device's newest sentence.
MESSAGE = "message"
LIGHTS = (
    PropertyState.IDLE.value,
    PropertyState.OK.value,
    PropertyState.BUSY.value,
    PropertyState.ALERT.value,
)
# Measured at a period, and sent each time: its arrival is the only sign that it is new.
_MEASURED = "WEATHER_PARAMETERS"
_BY_WEATHER = frozenset({_MEASURED, "WEATHER_STATUS"})

# By property: for each element the words while it moves and when it is there.
_WORDS: dict[str, dict[str, tuple[str, str]]] = {
    "DOME_SHUTTER": {"SHUTTER_OPEN": ("opening", "open"), "SHUTTER_CLOSE": ("closing", "closed")},
    "DOME_FLAP": {"FLAP_OPEN": ("opening", "open"), "FLAP_CLOSE": ("closing", "closed")},
    "DOME_PARK": {"PARK": ("parking", "parked"), "UNPARK": ("unparking", "unparked")},
    "TELESCOPE_PARK": {"PARK": ("parking", "parked"), "UNPARK": ("unparking", "unparked")},
    "CAP_PARK": {"PARK": ("closing", "closed"), "UNPARK": ("opening", "open")},
    "CONNECTION": {
        "CONNECT": ("connecting", "connected"),
        "DISCONNECT": ("disconnecting", "disconnected"),
    },
    "TELESCOPE_TRACK_STATE": {"TRACK_ON": ("on", "on"), "TRACK_OFF": ("off", "off")},
    "CCD_COOLER": {"COOLER_ON": ("on", "on"), "COOLER_OFF": ("off", "off")},
    "DOME_AUTOSYNC": {
        "DOME_AUTOSYNC_ENABLE": ("on", "on"),
        "DOME_AUTOSYNC_DISABLE": ("off", "off"),
    },
}


class PropertyReading(NamedTuple):
    """A value and when it was true, by the gateway's monotonic clock."""

    value: float | str
    mono_ns: int


def moving_words(name: str) -> tuple[str, ...]:
    """List the words a property of two ways may have: moving, there, and what can go wrong."""
    ways = _WORDS.get(name)
    if ways is None:
        return ()
    words = [word for pair in ways.values() for word in reversed(pair)]
    return (*dict.fromkeys(words), "error", "unknown")


def clock_of(device: IndiDevice, held: StoredVector) -> int:
    """Give when a vector's values were true last."""
    if held.name in _BY_WEATHER:
        measured = device.vectors.get(_MEASURED)
        return held.arrived_ns if measured is None else measured.arrived_ns
    return device.heard_ns


class DriverTimestamp(NamedTuple):
    """A driver's own time of its values.

    Attributes:
        stamp_ns: since the epoch, by the driver's clock; 0 when it gives none.
        arrived_ns: when it came, by the gateway's monotonic clock; none before the first.
        advanced_ns: when it was later than the one before, last; none when it never was.

    """

    stamp_ns: int
    arrived_ns: int | None
    advanced_ns: int | None


def stamp_of(book: IndiDeviceTree, device: str, name: str) -> DriverTimestamp | None:
    """Give the stamp of a vector; of the station's verdict that of what it measured."""
    found = book.devices.get(device)
    held = None if found is None else found.vectors.get(name)
    if found is None or held is None:
        return None
    if held.name in _BY_WEATHER:
        held = found.vectors.get(_MEASURED, held)
    stamp_ns = iso_stamp_ns(held.timestamp)
    return DriverTimestamp(stamp_ns, held.arrived_ns if stamp_ns else None, held.advanced_ns)


def read_number(
    book: IndiDeviceTree, device: str, name: str, element: str
) -> PropertyReading | None:
    """Read a number: a switch as 0 or 1, a light as its place in `LIGHTS`; NaN is unknown."""
    found = book.devices.get(device)
    held = None if found is None else found.vectors.get(name)
    if found is None or held is None or not _is_known(found, held):
        return None
    value = held.element_value(element)
    if value is None:
        return None
    if isinstance(value, str):
        number = float(LIGHTS.index(value)) if value in LIGHTS else math.nan
    else:
        number = float(value)
    return PropertyReading(number, clock_of(found, held))


def read_state(
    *, book: IndiDeviceTree, device: str, name: str, element: str, states: tuple[str, ...]
) -> PropertyReading | None:
    """Read a state as its place in ``states``; NaN where none of them fits."""
    found = book.devices.get(device)
    held = None if found is None else found.vectors.get(name)
    if found is None or held is None or not _is_known(found, held):
        return None
    return PropertyReading(_place(held, element, states), clock_of(found, held))


def _place(held: StoredVector, element: str, states: tuple[str, ...]) -> float:
    lowered = [word.lower() for word in states]

    def place_of(*words: str) -> int | None:
        return next(
            (lowered.index(word.lower()) for word in words if word.lower() in lowered), None
        )

    if element:
        value = held.element_value(element)
        if value is None:
            return math.nan
        if isinstance(value, bool):
            at = place_of("on" if value else "off")
            return float(value if at is None else at)
        if isinstance(value, float):
            return value
        return _by_word(place_of(value), LIGHTS.index(value) if value in LIGHTS else None, states)
    if held.kind is not VectorKind.SWITCH:
        return _by_word(place_of(held.state), LIGHTS.index(held.state), states)
    on = [element for element in held.elements.values() if element.value is True]
    ways = _WORDS.get(held.name)
    if ways is not None:
        at = place_of(_way_of(held, [element.name for element in on], ways))
        if at is not None:
            return float(at)
    if not on:
        at = place_of("none", "unknown")
        return math.nan if at is None else float(at)
    index = list(held.elements).index(on[0].name)
    return _by_word(place_of(on[0].label, on[0].name), index, states)


def _by_word(at: int | None, index: int | None, states: tuple[str, ...]) -> float:
    """Take the word's place, or else the place in the protocol's own order."""
    found = index if at is None else at
    return float(found) if found is not None and found < len(states) else math.nan


def _way_of(held: StoredVector, on: list[str], ways: dict[str, tuple[str, str]]) -> str:
    if held.state is PropertyState.ALERT:
        return "error"
    known = [name for name in on if name in ways]
    if len(known) != 1:
        return "unknown"
    return ways[known[0]][0 if held.state is PropertyState.BUSY else 1]


def read_text(book: IndiDeviceTree, device: str, name: str, element: str) -> PropertyReading | None:
    """Read a text; of a switch the label of what is on."""
    found = book.devices.get(device)
    if found is None:
        return None
    if name == MESSAGE:
        return PropertyReading(found.said[-1].message if found.said else "", found.heard_ns)
    held = found.vectors.get(name)
    if held is None or not _is_known(found, held):
        return None
    if element:
        value = held.element_value(element)
        if value is None:
            return None
        text = value if isinstance(value, str) else f"{float(value):g}"
    elif held.kind is VectorKind.SWITCH:
        on = [
            element.label or element.name
            for element in held.elements.values()
            if element.value is True
        ]
        text = ", ".join(on)
    else:
        text = str(held.state)
    return PropertyReading(text, clock_of(found, held))


def _is_known(device: IndiDevice, held: StoredVector) -> bool:
    """Tell whether the driver itself stands by its value."""
    if held.name in ("CONNECTION", "DRIVER_INFO"):
        return True
    # A weather driver whose station is silent keeps the last values and says so by its state.
    if held.name == _MEASURED and held.state is PropertyState.ALERT:
        return False
    return device.connected or "CONNECTION" not in device.vectors
