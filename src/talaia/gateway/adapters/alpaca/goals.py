"""When an Alpaca method is done: by what the device says of itself afterwards. Pure.

A method's answer only says that it began (ASCOM: "returns immediately"), so each has its goal: what
must rest, and what must then be so. Names and numbers are those of "ASCOM Master Interfaces"
(Platform 7). A method without a row has succeeded when the device has taken it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

from talaia.clock import SECOND
from talaia.gateway.adapters.alpaca.standard_signals import STANDARD_SIGNALS, SignalRow
from talaia.gateway.ports import CommandOutcome
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.gateway.adapters.alpaca.protocol import Scalar

__all__ = ["ABSENT", "METHODS", "AlpacaGoal", "MethodRow", "row_of", "stop_of"]

# Stands for the value of a property that the device says it has not.
ABSENT: Final = object()
# What rests elsewhere than asked for may only be between two movements.
SETTLE_NS = 3 * SECOND


class _Wanted(NamedTuple):
    """What a property must be in the end: a value, or that of the method's parameter."""

    property: str
    value: Scalar = ""
    field: str = ""
    near: float = 1e-6
    circle: float = 0.0  # After so much it is the same again; 0: never.
    may_lack: bool = False  # A device without such a property is believed by its rest alone.


class MethodRow(NamedTuple):
    """One method.

    Attributes:
        moving: property by property, the values with which it still moves.
        wanted: what must be so once it rests.
        failed: values that mean that it went wrong, with the words for it.
        stop: the method that ends it early, of the same device; empty for none.
        picture: it ends in a picture, which is fetched.

    """

    moving: Mapping[str, tuple[Scalar, ...]] = {}
    wanted: tuple[_Wanted, ...] = ()
    failed: Mapping[tuple[str, int], str] = {}
    stop: str = ""
    picture: bool = False

    def properties(self, fields: Mapping[str, Scalar]) -> list[str]:
        """Name what is asked for while it is under way; a switch's with its number."""
        names = [*self.moving, *(want.property for want in self.wanted)]
        names += [name for name, _ in self.failed]
        query = f"?Id={fields['Id']}" if "Id" in fields else ""
        return [f"{name}{query}" for name in dict.fromkeys(names)]


_SLEWING = {"slewing": (True,)}
_TURNING = {"ismoving": (True,)}
_SHUTTER = {"shutterstatus": (2, 3)}
_SHUTTER_WRONG = {("shutterstatus", 4): "the dome reports an error of its shutter"}
_COVER = {"coverstate": (2,)}
_COVER_WRONG = {("coverstate", 5): "the cover reports an error"}
_LAMP = {"calibratorstate": (2,)}
_LAMP_WRONG = {("calibratorstate", 5): "the calibrator reports an error"}
_CAMERA_WRONG = {("camerastate", 5): "the camera reports an error"}
_EQUATORIAL = (
    _Wanted("rightascension", field="RightAscension", near=0.1 / 15, circle=24.0),
    _Wanted("declination", field="Declination", near=0.1),
)

# By device type and method. Tolerances are in the property's own unit.
METHODS: dict[tuple[str, str], MethodRow] = {
    ("telescope", "slewtocoordinatesasync"): MethodRow(_SLEWING, _EQUATORIAL, stop="abortslew"),
    ("telescope", "slewtoaltazasync"): MethodRow(
        _SLEWING,
        (
            _Wanted("azimuth", field="Azimuth", near=0.2, circle=360.0),
            _Wanted("altitude", field="Altitude", near=0.2),
        ),
        stop="abortslew",
    ),
    ("telescope", "slewtotargetasync"): MethodRow(_SLEWING, stop="abortslew"),
    ("telescope", "synctocoordinates"): MethodRow(wanted=_EQUATORIAL),
    ("telescope", "park"): MethodRow(_SLEWING, (_Wanted("atpark", value=True),), stop="abortslew"),
    ("telescope", "unpark"): MethodRow(wanted=(_Wanted("atpark", value=False),)),
    ("telescope", "findhome"): MethodRow(
        _SLEWING, (_Wanted("athome", value=True),), stop="abortslew"
    ),
    ("telescope", "abortslew"): MethodRow(_SLEWING),
    ("telescope", "tracking"): MethodRow(wanted=(_Wanted("tracking", field="Tracking"),)),
    ("dome", "openshutter"): MethodRow(
        _SHUTTER, (_Wanted("shutterstatus", 0),), _SHUTTER_WRONG, stop="abortslew"
    ),
    ("dome", "closeshutter"): MethodRow(
        _SHUTTER, (_Wanted("shutterstatus", 1),), _SHUTTER_WRONG, stop="abortslew"
    ),
    ("dome", "slewtoazimuth"): MethodRow(
        _SLEWING,
        (_Wanted("azimuth", field="Azimuth", near=1.0, circle=360.0),),
        stop="abortslew",
    ),
    ("dome", "slewtoaltitude"): MethodRow(
        _SLEWING, (_Wanted("altitude", field="Altitude", near=1.0),), stop="abortslew"
    ),
    ("dome", "park"): MethodRow(_SLEWING, (_Wanted("atpark", value=True),), stop="abortslew"),
    ("dome", "findhome"): MethodRow(_SLEWING, (_Wanted("athome", value=True),), stop="abortslew"),
    ("dome", "abortslew"): MethodRow({**_SLEWING, **_SHUTTER}),
    ("dome", "slaved"): MethodRow(wanted=(_Wanted("slaved", field="Slaved"),)),
    ("camera", "startexposure"): MethodRow(
        # 1 waits, 2 exposes, 3 reads out, 4 sends.
        {"camerastate": (1, 2, 3, 4)},
        (_Wanted("imageready", value=True),),
        _CAMERA_WRONG,
        stop="abortexposure",
        picture=True,
    ),
    ("camera", "abortexposure"): MethodRow({"camerastate": (1, 2, 3, 4)}),
    ("camera", "binx"): MethodRow(wanted=(_Wanted("binx", field="BinX"),)),
    ("camera", "gain"): MethodRow(wanted=(_Wanted("gain", field="Gain"),)),
    ("camera", "cooleron"): MethodRow(wanted=(_Wanted("cooleron", field="CoolerOn"),)),
    ("camera", "setccdtemperature"): MethodRow(
        wanted=(_Wanted("setccdtemperature", field="SetCCDTemperature", near=0.5),)
    ),
    ("focuser", "move"): MethodRow(
        _TURNING, (_Wanted("position", field="Position", near=1.0, may_lack=True),), stop="halt"
    ),
    ("focuser", "halt"): MethodRow(_TURNING),
    ("focuser", "tempcomp"): MethodRow(wanted=(_Wanted("tempcomp", field="TempComp"),)),
    ("filterwheel", "position"): MethodRow(
        # -1 between two filters.
        {"position": (-1,)},
        (_Wanted("position", field="Position"),),
    ),
    ("rotator", "moveabsolute"): MethodRow(
        _TURNING, (_Wanted("position", field="Position", near=0.2, circle=360.0),), stop="halt"
    ),
    ("rotator", "movemechanical"): MethodRow(
        _TURNING,
        (_Wanted("mechanicalposition", field="Position", near=0.2, circle=360.0),),
        stop="halt",
    ),
    ("rotator", "move"): MethodRow(_TURNING, stop="halt"),
    ("rotator", "halt"): MethodRow(_TURNING),
    ("switch", "setswitch"): MethodRow(wanted=(_Wanted("getswitch", field="State"),)),
    ("switch", "setswitchvalue"): MethodRow(
        wanted=(_Wanted("getswitchvalue", field="Value", near=0.01),)
    ),
    ("covercalibrator", "opencover"): MethodRow(
        _COVER, (_Wanted("coverstate", 3),), _COVER_WRONG, stop="haltcover"
    ),
    ("covercalibrator", "closecover"): MethodRow(
        _COVER, (_Wanted("coverstate", 1),), _COVER_WRONG, stop="haltcover"
    ),
    ("covercalibrator", "haltcover"): MethodRow(_COVER),
    ("covercalibrator", "calibratoron"): MethodRow(
        _LAMP, (_Wanted("calibratorstate", 3),), _LAMP_WRONG, stop="calibratoroff"
    ),
    ("covercalibrator", "calibratoroff"): MethodRow(
        _LAMP, (_Wanted("calibratorstate", 1),), _LAMP_WRONG
    ),
}
_CONNECTED = MethodRow(wanted=(_Wanted("connected", field="Connected"),))
_TAKEN = MethodRow()
# By device type: what ends whatever it does.
_STOPS = {
    "telescope": "abortslew",
    "dome": "abortslew",
    "camera": "abortexposure",
    "focuser": "halt",
    "rotator": "halt",
    "covercalibrator": "haltcover",
}


def row_of(target: str) -> MethodRow:
    """Give the row of a method (``dome/0/openshutter``)."""
    kind, _, method = target.split("/")
    return _CONNECTED if method == "connected" else METHODS.get((kind, method), _TAKEN)


def stop_of(device: str) -> str:
    """Give the method that stops a device (``dome/0``); empty for one that does not move."""
    method = _STOPS.get(device.partition("/")[0])
    return f"{device}/{method}" if method else ""


class AlpacaGoal:
    """One method under way, after the device has taken it; `evaluate_values` after each look."""

    def __init__(self, target: str, fields: Mapping[str, Scalar], now_ns: int) -> None:
        """Judge a method with the parameters that it was called with."""
        self.row = row_of(target)
        self._type = target.partition("/")[0]
        self._fields = fields
        self._rest_ns: int | None = None  # Since when it rests elsewhere.
        self._began_ns = now_ns
        self.cancelled = False  # Its stop was asked for.

    @property
    def properties(self) -> list[str]:
        """What is to be asked for; none where there is nothing to wait for."""
        return self.row.properties(self._fields)

    def evaluate_values(self, values: Mapping[str, object], now_ns: int) -> CommandOutcome | None:
        """Say how it stands; none while that is not known.

        Args:
            values: by property, those that were read since it was taken.
            now_ns: monotonic.

        """
        found = {name.partition("?")[0]: value for name, value in values.items()}
        for (name, bad), words in self.row.failed.items():
            if _same(found.get(name), bad):
                return CommandOutcome(CommandPhase.FAILED, words)
        for name, while_moving in self.row.moving.items():
            if name not in found:
                return None
            if any(_same(found[name], value) for value in while_moving):
                self._rest_ns = None
                return CommandOutcome(CommandPhase.RUNNING, "", self._progress(now_ns))
        if self.cancelled:
            return CommandOutcome(CommandPhase.CANCELLED, "stopped")
        missing = [want for want in self.row.wanted if not self._is_reached(want, found)]
        if not missing:
            return CommandOutcome(CommandPhase.SUCCEEDED, self._words_of(found))
        if self._rest_ns is None:
            self._rest_ns = now_ns
        if now_ns - self._rest_ns < SETTLE_NS:
            return CommandOutcome(CommandPhase.RUNNING, "", self._progress(now_ns))
        rests = ", ".join(
            _words_of_value(self._type, want.property, found.get(want.property)) for want in missing
        )
        return CommandOutcome(CommandPhase.FAILED, f"it rests elsewhere than asked for: {rests}")

    def _progress(self, now_ns: int) -> float:
        """Only an exposure's is known: how much of its time is over."""
        seconds = self._fields.get("Duration")
        if not self.row.picture or not isinstance(seconds, float | int) or seconds <= 0:
            return 0.0
        return min(1.0, (now_ns - self._began_ns) / SECOND / seconds)

    def _is_reached(self, want: _Wanted, found: Mapping[str, object]) -> bool:
        value = found.get(want.property)
        if value is ABSENT:
            return want.may_lack
        # A parameter that was not given asks for nothing.
        asked = self._fields.get(want.field) if want.field else want.value
        if asked is None:
            return True
        if isinstance(asked, bool | str) or isinstance(value, bool | str):
            return _same(value, asked)
        if not isinstance(value, int | float):
            return False
        apart = abs(value - asked)
        if want.circle:
            apart = min(apart % want.circle, want.circle - apart % want.circle)
        return math.isfinite(apart) and apart <= want.near

    def _words_of(self, found: Mapping[str, object]) -> str:
        shown = [
            _words_of_value(self._type, want.property, value)
            for want in self.row.wanted
            if (value := found.get(want.property)) not in (None, ABSENT)
        ]
        return ", ".join(shown)[:200]


def _words_of_value(device_type: str, name: str, value: object) -> str:
    """Say what a property is, as pages call it: ``Shutter: open``, ``Set point: -10 °C``."""
    rows = STANDARD_SIGNALS.get(device_type, ())
    row = next((row for row in rows if row.source == name), SignalRow(name, ""))
    if value is None or value is ABSENT:
        shown = "unknown"
    elif isinstance(value, int) and value in range(len(row.states)):
        shown = row.states[value]
    elif isinstance(value, bool):
        shown = "on" if value else "off"
    else:
        number = f"{value:g}" if isinstance(value, float) else str(value)
        shown = f"{number} {row.unit}".rstrip()
    return f"{row.name}: {shown}" if row.name else shown


def _same(found: object, wanted: Scalar) -> bool:
    """Compare without taking a truth for a number: ``True == 1`` in Python."""
    return isinstance(found, bool) is isinstance(wanted, bool) and found == wanted
