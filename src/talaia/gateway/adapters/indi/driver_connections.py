"""Connects drivers to their hardware, and sets them up once they are. Pure.

Who is connected again by itself, and who is not:

- A driver that has just come, or was started anew by the server after a crash, is told to connect,
  at once and then with growing pauses.
- One that gave up its hardware with *Alert* is told so, too.
- One that somebody disconnected (a person here, or any other client of the server) is left so,
  also when its driver or the server is started anew, until somebody connects it. Whoever works at
  the hardware must not be surprised by it. The gateway's own start forgets that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND
from talaia.gateway.adapters.indi.protocol import (
    PropertyPermission,
    PropertyState,
    VectorKind,
    new_vector,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from talaia.gateway.adapters.indi.protocol import Value
    from talaia.gateway.adapters.indi.state import IndiDevice, StoredVector

    Setup = Mapping[str, Mapping[str, Value]]

__all__ = ["DriverConnections", "DriverProblem"]

CONNECT_AGAIN_NS = (5 * SECOND, 10 * SECOND, 30 * SECOND, 60 * SECOND)
# Connected for so long, a driver is no crash loop: its next crash is mended at once again.
STEADY_NS = 60 * SECOND
# Properties come in the seconds after a connect; one that has not by then is told as missing.
DEFINED_WITHIN_NS = 15 * SECOND


class DriverProblem(NamedTuple):
    """A trouble of a driver to be written down."""

    kind: str
    message: str


@dataclass(slots=True)
class _Write:
    """One property that is still to be written.

    Attributes:
        since_ns: the driver is connected since.
        sets: how often the driver had set it when it was asked; none before it was.

    """

    since_ns: int
    due_ns: int = 0
    tries: int = 0
    sets: int | None = None
    told: bool = False


@dataclass(slots=True)
class _Driver:
    """What was done with one driver.

    Attributes:
        tries: how often it was told to connect since it last held for `STEADY_NS`.
        in_vain: the same since it was last connected or came.
        left: somebody disconnected it.
        lost: it was connected, and its driver was started anew.
        sets: how often it had told of its connection when it was last seen connected.

    """

    tries: int = 0
    in_vain: int = 0
    due_ns: int = 0
    connected: bool = False
    since_ns: int = 0
    left: bool = False
    lost: bool = False
    sets: int = 0
    writes: dict[str, _Write] = field(default_factory=dict)


class DriverConnections:
    """All drivers of one server."""

    def __init__(self, setups: Mapping[str, Setup], *, connect: bool) -> None:
        """Take what is written after each connect, by INDI device, and whether to connect."""
        self._setups = setups
        self._connect = connect
        self._drivers: dict[str, _Driver] = {}

    def restart(self) -> None:
        """Begin with a server anew. Who was left by a person stays so."""
        kept = {name: _Driver(left=True) for name, driver in self._drivers.items() if driver.left}
        self._drivers = kept

    def redefine(self, device: str) -> None:
        """Take in that the driver has come, or has come again: it knows nothing of before."""
        known = self._drivers.get(device)
        if known is None:
            return
        known.lost = known.connected
        known.connected = False
        known.in_vain = 0
        known.writes.clear()

    def set_wanted(self, device: str, *, connect: bool, now_ns: int) -> None:
        """Take in that a person connects or disconnects it."""
        known = self._drivers.setdefault(device, _Driver())
        known.left = not connect
        # The person's own ask goes first; ours follow if that fails.
        known.due_ns = now_ns + CONNECT_AGAIN_NS[0]

    def connect_again(self, device: str) -> None:
        """Connect it at the next look, whatever was before."""
        self._drivers.pop(device, None)

    def is_left(self, device: str) -> bool:
        """Tell whether somebody has disconnected it."""
        known = self._drivers.get(device)
        return known is not None and known.left

    def count_tries(self, device: str) -> int:
        """Tell how often it was told to connect without having been connected since."""
        known = self._drivers.get(device)
        return 0 if known is None else known.in_vain

    def next_actions(self, device: IndiDevice, now_ns: int) -> Iterator[bytes | DriverProblem]:
        """Give what is to be sent and written down now."""
        held = device.vectors.get("CONNECTION")
        known = self._drivers.setdefault(device.name, _Driver())
        # A driver without the property needs no connecting.
        if held is None or device.connected:
            yield from self._on_connected(device, known, now_ns)
            return
        if held.state is PropertyState.BUSY:
            return
        if known.connected:
            known.connected = False
            known.writes.clear()
            # Said by a Set event, it was done; defined so once more, it has been started anew.
            done = held.sets != known.sets
            known.left |= done and held.state is not PropertyState.ALERT
            known.lost = not done
        if known.left or not self._connect or now_ns < known.due_ns:
            return
        if known.lost:
            known.lost = False
            yield DriverProblem("driver_restarted", "its driver was started anew; connecting it")
        if known.in_vain == 1:
            said = device.said[-1].message if device.said else "no reason given"
            yield DriverProblem("driver_not_connected", said)
        known.due_ns = now_ns + CONNECT_AGAIN_NS[min(known.tries, len(CONNECT_AGAIN_NS) - 1)]
        known.tries += 1
        known.in_vain += 1
        yield from self._setup_before(device)
        asked = {"CONNECT": True, "DISCONNECT": False}
        yield new_vector(VectorKind.SWITCH, device.name, "CONNECTION", asked)

    def _setup_before(self, device: IndiDevice) -> Iterator[bytes]:
        """Write what the driver has already: without its port or address it cannot connect.

        What does not fit, or is refused, is said once it is connected, when all is written anew.
        """
        for name, values in self._setups.get(device.name, {}).items():
            held = device.vectors.get(name)
            if (
                held is not None
                and not _has_values(held, values)
                and not _misfit_reason(held, values)
            ):
                yield _asked_for(held, device.name, name, values)

    def _on_connected(
        self, device: IndiDevice, known: _Driver, now_ns: int
    ) -> Iterator[bytes | DriverProblem]:
        held = device.vectors.get("CONNECTION")
        known.sets = 0 if held is None else held.sets
        if not known.connected:
            known.connected, known.since_ns = True, now_ns
            known.left, known.lost, known.in_vain = False, False, 0
            known.writes = {name: _Write(now_ns) for name in self._setups.get(device.name, ())}
        elif now_ns - known.since_ns >= STEADY_NS:
            known.tries = known.due_ns = 0
        for name, write in list(known.writes.items()):
            values = self._setups[device.name][name]
            yield from _write_property(
                device=device, name=name, values=values, write=write, now_ns=now_ns
            )
            if _is_written(device.vectors.get(name), values, write):
                del known.writes[name]


def _is_written(held: StoredVector | None, values: Mapping[str, Value], write: _Write) -> bool:
    if held is None:
        return False
    if _has_values(held, values):
        return True
    # A driver may round, or write an angle in its own way: that it took it is enough.
    later = write.sets is not None and held.sets > write.sets
    return later and held.state in (PropertyState.OK, PropertyState.IDLE)


def _has_values(held: StoredVector, values: Mapping[str, Value]) -> bool:
    return all(_same_value(held.element_value(element), value) for element, value in values.items())


def _asked_for(held: StoredVector, device: str, name: str, values: Mapping[str, Value]) -> bytes:
    # The other members of a vector go along as they are: many drivers want all of them.
    rest = {} if held.kind is VectorKind.SWITCH else {k: e.value for k, e in held.elements.items()}
    known = {k: v for k, v in rest.items() if not isinstance(v, float) or math.isfinite(v)}
    return new_vector(held.kind, device, name, {**known, **values})


def _write_property(
    *, device: IndiDevice, name: str, values: Mapping[str, Value], write: _Write, now_ns: int
) -> Iterator[bytes | DriverProblem]:
    """Ask for one property's values, unless they are there or it is not time."""
    held = device.vectors.get(name)
    if _is_written(held, values, write) or now_ns < write.due_ns:
        return
    if held is None:
        if now_ns - write.since_ns >= DEFINED_WITHIN_NS and not write.told:
            write.told = True
            yield DriverProblem("driver_not_set_up", f"it has no property {name}")
        return
    problem = _misfit_reason(held, values)
    if not problem and write.sets is not None and held.state is PropertyState.ALERT:
        problem = device.said[-1].message if device.said else "the driver says Alert"
    if problem and not write.told:
        write.told = True
        yield DriverProblem("driver_not_set_up", f"{name}: {problem}")
    again = CONNECT_AGAIN_NS[min(write.tries, len(CONNECT_AGAIN_NS) - 1)]
    write.tries += 1
    write.due_ns = now_ns + again
    if _misfit_reason(held, values):
        return
    write.sets = held.sets
    yield _asked_for(held, device.name, name, values)


def _misfit_reason(held: StoredVector, values: Mapping[str, Value]) -> str:
    """Say why these values cannot be written to a property; empty where they can."""
    if held.perm is PropertyPermission.READ or held.kind not in (
        VectorKind.NUMBER,
        VectorKind.SWITCH,
        VectorKind.TEXT,
    ):
        return "it cannot be set"
    for element, value in values.items():
        known = held.elements.get(element)
        if known is None:
            return f"it has no {element}; it has {', '.join(held.elements)}"
        if held.kind is VectorKind.SWITCH and not isinstance(value, bool):
            return f"{element} is a switch: expected true or false, found {value!r}"
        if held.kind is VectorKind.NUMBER:
            if isinstance(value, bool | str) or not math.isfinite(value):
                return f"{element} is a number, found {value!r}"
            if known.minimum < known.maximum and not known.minimum <= value <= known.maximum:
                return f"{element}: {value:g} is not within {known.minimum:g} and {known.maximum:g}"
        if held.kind is VectorKind.TEXT and not isinstance(value, str):
            return f"{element} is a text: write {str(value)!r} in quotes"
    return ""


def _same_value(now: Value | None, wanted: Value) -> bool:
    if isinstance(now, bool) or isinstance(wanted, bool) or now is None:
        return now is wanted
    if isinstance(now, str) or isinstance(wanted, str):
        return now == wanted
    return math.isclose(now, wanted, rel_tol=1e-6, abs_tol=1e-6)
