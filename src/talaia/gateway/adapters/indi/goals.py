"""Commands to a device, judged by the goal that a later Set event shows. Pure.

INDI's states are no verdict: a goto that a parked mount refuses comes back *Idle*, a repeated
command *Ok*, and a park is *Ok* while the shutter still moves (measured with indi-bin 1.9.9). So
a command has succeeded when the values that were asked for have come, after it, and nothing that
belongs to it moves any more. What the driver said meanwhile is shown as it is.

Long, because asking, refusing and judging look at the same properties.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND
from talaia.gateway.adapters.indi.numbers import format_number
from talaia.gateway.adapters.indi.protocol import (
    PropertyPermission,
    PropertyState,
    SwitchRule,
    VectorKind,
    new_vector,
)
from talaia.gateway.ports import CommandOutcome
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.gateway.adapters.indi.protocol import Value
    from talaia.gateway.adapters.indi.state import IndiDevice, IndiDeviceTree, StoredVector

__all__ = ["CHOICE", "IndiGoal", "begin_goal"]

# The field that takes the name of the element to switch on, instead of a value for an element.
CHOICE = "*"
SILENT_NS = 5 * SECOND
# A driver may say *Ok* before it begins to move; only a state that stays is believed.
SETTLE_NS = 3 * SECOND
_POINTING = "EQUATORIAL_EOD_COORD"
_EXPOSURE = "CCD_EXPOSURE"

# What else must rest before a command is over.
_MOVES_WITH: dict[str, tuple[str, ...]] = {
    "DOME_PARK": ("ABS_DOME_POSITION", "DOME_SHUTTER"),
    "DOME_ABORT_MOTION": ("ABS_DOME_POSITION", "DOME_SHUTTER", "DOME_PARK"),
    "TELESCOPE_PARK": (_POINTING,),
    "TELESCOPE_ABORT_MOTION": (_POINTING,),
    "CCD_ABORT_EXPOSURE": (_EXPOSURE,),
    "FOCUS_ABORT_MOTION": ("ABS_FOCUS_POSITION",),
    "REL_FOCUS_POSITION": ("ABS_FOCUS_POSITION",),
    "ROTATOR_ABORT_MOTION": ("ABS_ROTATOR_ANGLE",),
}
# What stops it, to cancel a command.
_STOPS: dict[str, tuple[str, str]] = {
    _POINTING: ("TELESCOPE_ABORT_MOTION", "ABORT"),
    "TELESCOPE_PARK": ("TELESCOPE_ABORT_MOTION", "ABORT"),
    "ABS_DOME_POSITION": ("DOME_ABORT_MOTION", "ABORT"),
    "DOME_SHUTTER": ("DOME_ABORT_MOTION", "ABORT"),
    "DOME_PARK": ("DOME_ABORT_MOTION", "ABORT"),
    _EXPOSURE: ("CCD_ABORT_EXPOSURE", "ABORT"),
    "ABS_FOCUS_POSITION": ("FOCUS_ABORT_MOTION", "ABORT"),
    "REL_FOCUS_POSITION": ("FOCUS_ABORT_MOTION", "ABORT"),
    "ABS_ROTATOR_ANGLE": ("ROTATOR_ABORT_MOTION", "ABORT"),
}
_ABORTS = ("ABORT_MOTION", "ABORT_EXPOSURE")
# How near is there, in the property's own unit; and what is a circle.
_NEAR = {"ABS_DOME_POSITION": 1.0, "ABS_ROTATOR_ANGLE": 0.2, "CCD_TEMPERATURE": 0.6}
_NEAR_SKY_DEG = 0.1
_CIRCLES = frozenset({"ABS_DOME_POSITION", "ABS_ROTATOR_ANGLE"})
# Their value is what is asked for, not where they are: only that they rest says they are done.
_RELATIVE = frozenset({"REL_FOCUS_POSITION", "REL_DOME_POSITION"})


class _Ask(NamedTuple):
    """What is asked of one property."""

    held: StoredVector
    values: dict[str, Value]


def begin_goal(
    *, book: IndiDeviceTree, device: str, target: str, fields: Mapping[str, Value], now_ns: int
) -> IndiGoal | str:
    """Begin a command: give its goal, or the sentence that says why it cannot be asked.

    Args:
        book: what is known.
        device: the INDI device.
        target: the property that decides when it is over.
        fields: values by element; ``PROPERTY/ELEMENT`` for another property that is set before,
            and `CHOICE` in the place of an element for the element that is to be on.
        now_ns: monotonic.

    """
    found = book.devices.get(device)
    if found is None:
        return f"the INDI server has no device {device!r} now"
    if now_ns - found.heard_ns > SILENT_NS:
        silent = (now_ns - found.heard_ns) / SECOND
        return f"the driver of {device} has not answered for {silent:.0f} s"
    if target != "CONNECTION" and not found.connected and "CONNECTION" in found.vectors:
        return f"the driver of {device} is not connected to its hardware"
    wanted: dict[str, dict[str, Value]] = {}
    for field, value in fields.items():
        before, _, element = field.rpartition("/")
        wanted.setdefault(before or target, {})[element] = value
    asks: list[_Ask] = []
    for name in [*(value for value in wanted if value != target), target]:
        ask = _make_ask(found, name, wanted.get(name, {}))
        if isinstance(ask, str):
            return ask
        if ask is not None:
            asks.append(ask)
    barred = _motion_problem(found, asks)
    return barred or IndiGoal(found, target, asks, now_ns)


def _make_ask(device: IndiDevice, name: str, values: dict[str, Value]) -> _Ask | str | None:
    held = device.vectors.get(name)
    if held is None:
        return f"{device.name} has no property {name} now"
    if held.perm is PropertyPermission.READ or held.kind not in (
        VectorKind.NUMBER,
        VectorKind.SWITCH,
        VectorKind.TEXT,
    ):
        return f"{name} of {device.name} cannot be set"
    filled: dict[str, Value] = {}
    for element, value in values.items():
        if element == CHOICE:
            chosen = _choose_element(held, str(value))
            if chosen is None:
                known = ", ".join(
                    element.label or element.name for element in held.elements.values()
                )
                return f"{value!r} is none of: {known}"
            filled[chosen] = True
            continue
        if element not in held.elements:
            return f"{name} of {device.name} has no {element}"
        problem = _range_problem(held, element, value)
        if problem:
            return problem
        filled[element] = value
    return _Ask(held, filled) if filled else None


def _choose_element(held: StoredVector, word: str) -> str | None:
    """Find an element by its name or label, as a person writes it."""
    asked = word.strip().lower()
    for element in held.elements.values():
        if asked in (element.name.lower(), element.label.lower()):
            return element.name
    tails = [
        element for element in held.elements if asked and element.lower().endswith(f"_{asked}")
    ]
    return tails[0] if len(tails) == 1 else None


def _range_problem(held: StoredVector, element: str, value: Value) -> str:
    known = held.elements[element]
    label = known.label or known.name
    if held.kind is not VectorKind.NUMBER:
        return ""
    if isinstance(value, str) or not math.isfinite(value):
        return f"{label}: expected a finite number"
    # Equal limits mean none.
    if known.minimum < known.maximum and not known.minimum <= value <= known.maximum:
        low, high = (format_number(limit, "%g") for limit in (known.minimum, known.maximum))
        return f"{label}: {value:g} is not within {low} and {high}"
    return ""


def _motion_problem(device: IndiDevice, asks: list[_Ask]) -> str:
    names = [ask.held.name for ask in asks]
    if _POINTING in names and device.element_value("TELESCOPE_PARK", "PARK") is True:
        return f"{device.name} is parked; unpark it first"
    if "ABS_DOME_POSITION" in names and device.element_value("DOME_PARK", "PARK") is True:
        return f"{device.name} is parked; unpark it first"
    exposing = device.vectors.get(_EXPOSURE)
    if _EXPOSURE in names and exposing is not None and exposing.state is PropertyState.BUSY:
        return f"{device.name} is exposing; abort that first"
    return ""


class IndiGoal:
    """One command under way. `look` after each event and now and then."""

    def __init__(self, device: IndiDevice, target: str, asks: list[_Ask], now_ns: int) -> None:
        """Remember how things stood."""
        self.device = device.name
        self.target = target
        self._asks = asks
        self._began_ns = now_ns
        self._sets = {ask.held.name: ask.held.sets for ask in asks}
        # Under way already: asked once more, a mount aborts its parking. It is waited for instead.
        self._under_way = {ask.held.name for ask in asks if _is_under_way(ask)}
        self._rest_ns: int | None = None
        self._start = self._goal_distance(device)
        self._picture: str | None = None
        self._cancelled = False
        self._told = ""

    def outgoing_bytes(self, book: IndiDeviceTree) -> bytes:
        """Give what is sent to the server. Other members of a vector go along as they are."""
        parts = []
        for held, values in self._asks:
            if held.name in self._under_way:
                continue
            filled = dict(values)
            now = book.find_vector(held.device, held.name)
            if held.kind is not VectorKind.SWITCH and now is not None:
                rest = {element.name: element.value for element in now.elements.values()}
                filled = {
                    name: values.get(name, value)
                    for name, value in rest.items()
                    if name in values or not isinstance(value, float) or math.isfinite(value)
                }
            parts.append(new_vector(held.kind, held.device, held.name, filled))
        return b"".join(parts)

    def cancel_bytes(self, book: IndiDeviceTree) -> bytes:
        """Give what stops it; nothing where the device has no way to stop."""
        stop = _STOPS.get(self.target)
        held = book.find_vector(self.device, stop[0]) if stop is not None else None
        if stop is None or held is None:
            return b""
        self._cancelled = True
        return new_vector(VectorKind.SWITCH, self.device, stop[0], {stop[1]: True})

    def handle_picture(self, problem: str) -> None:
        """Note that a picture of the device has come, with what is wrong with it, if so."""
        if self.target == _EXPOSURE:
            self._picture = problem

    def evaluate_progress(self, book: IndiDeviceTree, now_ns: int) -> CommandOutcome | None:
        """Say how it stands, if there is anything to say."""
        device = book.devices.get(self.device)
        held = None if device is None else device.vectors.get(self.target)
        if device is None or held is None:
            gone = f"{self.device} went away meanwhile; look at the device"
            return CommandOutcome(CommandPhase.UNKNOWN, gone)
        if self._picture is not None:
            if self._picture:
                return CommandOutcome(
                    CommandPhase.FAILED, f"the picture is of no use: {self._picture}"
                )
            return CommandOutcome(
                CommandPhase.SUCCEEDED, self._newest_words(device) or "the picture has come"
            )
        if not all(self._is_later(device, ask.held.name) for ask in self._asks):
            return None
        words = self._newest_words(device)
        # Drivers call the abort of a motion an Alert: that nothing moves any more is what counts.
        if held.state is PropertyState.ALERT and not self.target.endswith(_ABORTS):
            return CommandOutcome(CommandPhase.FAILED, words or "the driver says Alert")
        if self._still_moves(device, held):
            self._rest_ns = None
            return self._running_outcome(device, held, words)
        if self._cancelled:
            return CommandOutcome(CommandPhase.CANCELLED, words or "stopped")
        if self.target == _EXPOSURE:
            return self._exposure_outcome(device, held, words, now_ns)
        if self._has_reached(device):
            return CommandOutcome(CommandPhase.SUCCEEDED, words or self._show_vector(held))
        # At rest, and elsewhere.
        problem = self._driver_problem(device)
        if problem:
            return CommandOutcome(CommandPhase.REFUSED, problem)
        if self._rest_ns is None:
            self._rest_ns = now_ns
        if now_ns - self._rest_ns < SETTLE_NS:
            return None
        rests = f"it rests at {self._show_vector(held)}"
        return CommandOutcome(CommandPhase.FAILED, f"{rests}; {words}" if words else rests)

    def _is_later(self, device: IndiDevice, name: str) -> bool:
        held = device.vectors.get(name)
        return name in self._under_way or (held is not None and held.sets > self._sets[name])

    def _still_moves(self, device: IndiDevice, held: StoredVector) -> bool:
        others = (device.vectors.get(name) for name in _MOVES_WITH.get(self.target, ()))
        busy = held.state is PropertyState.BUSY and not self._settled_while_busy(held)
        return busy or any(
            vector is not None and vector.state is PropertyState.BUSY for vector in others
        )

    def _settled_while_busy(self, held: StoredVector) -> bool:
        """A switch of which any may be on is as it is asked for at once, whatever its state."""
        return held.kind is VectorKind.SWITCH and held.rule is SwitchRule.ANY

    def _running_outcome(
        self, device: IndiDevice, held: StoredVector, words: str
    ) -> CommandOutcome | None:
        progress = 0.0
        if self.target == _EXPOSURE:
            asked = self._asked_number(_EXPOSURE, "CCD_EXPOSURE_VALUE")
            left = held.element_value("CCD_EXPOSURE_VALUE")
            if asked and isinstance(left, float):
                progress = 1.0 - left / asked
        elif self._start:
            left_now = self._goal_distance(device)
            progress = 0.0 if left_now is None else 1.0 - left_now / self._start
        said = words if words != self._told else ""
        self._told = words
        return CommandOutcome(CommandPhase.RUNNING, said, min(1.0, max(0.0, progress)))

    def _exposure_outcome(
        self, device: IndiDevice, held: StoredVector, words: str, now_ns: int
    ) -> CommandOutcome | None:
        """Over without a picture: aborted, or it was kept where the driver runs."""
        if held.state is PropertyState.IDLE:
            return CommandOutcome(CommandPhase.CANCELLED, words or "the exposure was aborted")
        if device.element_value("UPLOAD_MODE", "UPLOAD_LOCAL") is True:
            return CommandOutcome(
                CommandPhase.SUCCEEDED, words or "the picture is kept by the driver"
            )
        if self._rest_ns is None:
            self._rest_ns = now_ns
        # Reading out and sending a large picture takes long; the command's own time-out bounds it.
        return (
            CommandOutcome(CommandPhase.RUNNING, "", 1.0)
            if now_ns - self._rest_ns < SECOND
            else None
        )

    def _has_reached(self, device: IndiDevice) -> bool:
        return all(self._is_there(device, ask) for ask in self._asks)

    def _is_there(self, device: IndiDevice, ask: _Ask) -> bool:
        name = ask.held.name
        held = device.vectors.get(name)
        if held is None:
            return False
        if name in _RELATIVE:
            return True
        if name == _POINTING:
            left = self._goal_distance(device)
            return left is not None and left <= _NEAR_SKY_DEG
        if (
            held.kind is VectorKind.SWITCH
            and len(held.elements) == 1
            and held.rule is not SwitchRule.ANY
        ):
            return True  # a button: it springs back
        for element, asked in ask.values.items():
            now = held.element_value(element)
            if held.kind is VectorKind.NUMBER:
                if not isinstance(now, float) or not _is_near(held, element, now, float(asked)):
                    return False
            elif now != asked:
                return False
        return True

    def _goal_distance(self, device: IndiDevice) -> float | None:
        """How far it is from the goal: degrees on the sky, or in the property's unit."""
        if self.target == _POINTING:
            ra, dec = (device.element_value(_POINTING, element) for element in ("RA", "DEC"))
            asked = (self._asked_number(_POINTING, "RA"), self._asked_number(_POINTING, "DEC"))
            if not isinstance(ra, float) or not isinstance(dec, float) or None in asked:
                return None
            return _angular_separation(ra * 15.0, dec, (asked[0] or 0.0) * 15.0, asked[1] or 0.0)
        if self.target in _RELATIVE or not self._asks:
            return None
        held, values = self._asks[-1]
        if held.kind is not VectorKind.NUMBER or len(values) != 1:
            return None
        (element, asked_value), *_ = values.items()
        now = device.element_value(held.name, element)
        if not isinstance(now, float):
            return None
        return _value_difference(held.name, now, float(asked_value))

    def _asked_number(self, name: str, element: str) -> float | None:
        for held, values in self._asks:
            if held.name == name and element in values:
                return float(values[element])
        return None

    def _newest_words(self, device: IndiDevice) -> str:
        """Give the driver's newest sentence since the command began."""
        said = [message.message for message in device.said if message.mono_ns >= self._began_ns]
        return _strip_level(said[-1]) if said else ""

    def _driver_problem(self, device: IndiDevice) -> str:
        said = [message.message for message in device.said if message.mono_ns >= self._began_ns]
        bad = [text for text in said if text.startswith(("[WARNING]", "[ERROR]"))]
        return _strip_level(bad[-1]) if bad else ""

    def _show_vector(self, held: StoredVector) -> str:
        if held.kind is VectorKind.SWITCH:
            on = [
                element.label or element.name
                for element in held.elements.values()
                if element.value is True
            ]
            return ", ".join(on) or str(held.state)
        if held.kind is VectorKind.NUMBER:
            return ", ".join(
                f"{element.label or element.name} "
                f"{format_number(float(element.value), element.format).strip()}"
                for element in held.elements.values()
            )
        return ", ".join(str(element.value) for element in held.elements.values())


def _is_under_way(ask: _Ask) -> bool:
    held = ask.held
    return (
        held.kind is VectorKind.SWITCH
        and held.state is PropertyState.BUSY
        and len(held.elements) > 1
        and all(held.element_value(element) == asked for element, asked in ask.values.items())
    )


def _is_near(held: StoredVector, element: str, now: float, asked: float) -> bool:
    step = held.elements[element].step
    # A step of the hardware may be coarse; a tenth of it is surely the same place.
    near = max(_NEAR.get(held.name, 0.0), step / 10 if step > 0 else 0.0, 1e-6 * abs(asked), 1e-9)
    return _value_difference(held.name, now, asked) <= near


def _value_difference(name: str, now: float, asked: float) -> float:
    apart = abs(now - asked)
    if name in _CIRCLES:
        apart %= 360.0
        return min(apart, 360.0 - apart)
    return apart


def _angular_separation(ra1: float, dec1: float, ra2: float, dec2: float) -> float:
    """Angle between two directions (all in degrees), exact for small ones (haversine)."""
    a1, d1, a2, d2 = map(math.radians, (ra1, dec1, ra2, dec2))
    half = math.sin((d2 - d1) / 2) ** 2 + math.cos(d1) * math.cos(d2) * math.sin((a2 - a1) / 2) ** 2
    return math.degrees(2 * math.asin(min(1.0, math.sqrt(half))))


def _strip_level(message: str) -> str:
    """Take off the driver's level: ``[INFO] Dome is parked.``."""
    if message.startswith("[") and "] " in message:
        return message.split("] ", 1)[1]
    return message
