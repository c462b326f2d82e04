"""Cross-checks of signals that are worked out from others; part of `check`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.alarms.constant_parts import ZERO_REMEDY, zero_division_problem
from talaia.model.alarms.expression import ExpressionError, ValueKind, parse_expression
from talaia.model.checks.identifiers import Finding
from talaia.model.closed_lists import SignalType, Visibility
from talaia.model.derivation.inferred_units import channel_quantities, infer_quantity
from talaia.model.derivation.plan import channel_kinds, derived_addresses, find_cycle
from talaia.model.derivation.source import DerivedSource
from talaia.model.derived_signals import counts_of
from talaia.model.detection import DetectAt
from talaia.model.units.quantity import quantity_of_unit

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.alarms.expression import Expression
    from talaia.model.site import Signal, Site
    from talaia.model.units.quantity import Quantity

__all__ = ["derivation_findings"]

# Each may be worked out twenty times a second.
_MOST = 500


def derivation_findings(site: Site) -> Iterator[Finding]:
    """List what is wrong with signals that are worked out; ``site`` has its cameras' counts."""
    derived = derived_addresses(site)
    # What units measure is asked for only then: for rare ones a library is imported.
    if not derived:
        return
    if len(derived) > _MOST:
        problem = f"more than {_MOST} signals are worked out from others"
        yield Finding("$.devices", problem, "leave some to the charts")
    kinds, units = channel_kinds(site), channel_quantities(site)
    far = {address for address, (_, detect) in counts_of(site).items() if detect.at is DetectAt.HUB}
    expressions: dict[str, Expression] = {}
    for address in sorted(derived):
        signal = site.signal(address)
        if signal is None or not isinstance(signal.source, DerivedSource):
            continue
        where = _place_of(address)
        yield from _check_keys(where, signal, signal.source)
        try:
            found = parse_expression(signal.source.expression, kinds)
        except ExpressionError as error:
            yield Finding(f"{where}.source.expression", str(error), error.remedy)
            continue
        if problem := zero_division_problem(found):
            yield Finding(f"{where}.source.expression", problem, ZERO_REMEDY)
        expressions[address] = found
        yield from _check_result(where, signal, found, units)
        yield from _check_inputs(site, where, signal, found, far=far)
    yield from _cycle_findings(expressions)
    yield from _safety_findings(site, derived)


def _place_of(address: str) -> str:
    device, _, name = address.partition("/")
    return f"$.devices.{device}.signals.{name}"


def _check_keys(where: str, signal: Signal, source: DerivedSource) -> Iterator[Finding]:
    # Which of the two sources was meant nobody can tell.
    for key in source.foreign:
        problem = "what is worked out from other signals comes from nowhere else"
        yield Finding(f"{where}.source.{key}", problem, "leave it out, or leave out expression")
    if signal.scale != 1:
        problem = "what is worked out has no scale"
        yield Finding(f"{where}.scale", problem, "multiply in the expression")
    if signal.frozen_after:
        problem = "a sensor can freeze, a calculation cannot"
        yield Finding(f"{where}.frozen_after", problem, "write it at the signals in the expression")


def _check_result(
    where: str, signal: Signal, found: Expression, units: dict[str, Quantity]
) -> Iterator[Finding]:
    at = f"{where}.source.expression"
    if not found.signals:
        yield Finding(at, "there is no signal in it", "write {device/signal}")
        return
    gives = found.tree.kind
    wanted = {SignalType.NUMBER: ValueKind.NUMBER, SignalType.STATE: ValueKind.TRUTH}
    # A text would only be a copy of a signal.
    if gives is ValueKind.TEXT:
        yield Finding(at, "it gives a text", 'compare it: {device/mode} == "on"')
        return
    if wanted.get(signal.type) is not gives:
        word = "number" if gives is ValueKind.NUMBER else 'state, and states: ["no", "yes"]'
        yield Finding(f"{where}.type", f"its expression gives a {gives}", f"write: type: {word}")
        return
    if signal.type is SignalType.STATE and len(signal.states) != 2:
        problem = f"a condition has two states, found {len(signal.states)}"
        yield Finding(f"{where}.states", problem, 'write: states: ["no", "yes"]')
    try:
        quantity = infer_quantity(found.tree, units)
    except ExpressionError as error:
        remedy = "multiply one of them by a number that makes them one unit"
        yield Finding(at, str(error), remedy)
        return
    if signal.type is SignalType.NUMBER and not quantity.fits_unit(signal.unit):
        problem = f"expected {signal.unit or 'no unit'}, and the expression gives "
        remedy = f"write: unit: {quantity.symbol}" if quantity.symbol else "leave the unit out"
        # Of the same kind: it may be the number that is meant, and not the unit.
        if quantity_of_unit(signal.unit).powers == quantity.powers:
            remedy += ", or multiply by a number that converts it"
        yield Finding(at, problem + quantity.unit_name, remedy)


def _check_inputs(
    site: Site, where: str, signal: Signal, found: Expression, *, far: set[str]
) -> Iterator[Finding]:
    at = f"{where}.source.expression"
    for channel in found.signals:
        # Of a position one part is named.
        address = channel.partition(".")[0]
        if address in far:
            problem = f"{address} is seen at the hub, and the gateway works this out"
            yield Finding(at, problem, "write at the stream's detect: at: gateway")
        described = site.signal(address)
        # A guest could otherwise read a hidden signal through a copy of it.
        hidden = described is not None and described.visibility is not Visibility.PUBLIC
        if signal.visibility is Visibility.PUBLIC and hidden:
            problem = f"guests would see {address} in it, which they may not see"
            yield Finding(f"{where}.visibility", problem, "leave it out")


def _cycle_findings(expressions: dict[str, Expression]) -> Iterator[Finding]:
    needs = {
        address: tuple(name for name in found.signals if name in expressions)
        for address, found in expressions.items()
    }
    told: set[str] = set()
    for address in needs:
        # Each circle once, at the first of its signals.
        if address not in told and (cycle := find_cycle(needs, address)):
            told.update(cycle)
            problem = f"it is worked out from itself: {' ← '.join(cycle)}"
            remedy = "take one of them out of an expression"
            yield Finding(f"{_place_of(address)}.source.expression", problem, remedy)


def _safety_findings(site: Site, derived: frozenset[str]) -> Iterator[Finding]:
    """Refuse what interlocks, enclosures and STOP would go by: see decision 0077."""
    guarded = set(site.safety_signals())
    for device in site.devices.values():
        if device.drive is not None:
            guarded |= {device.drive.keys.speed, device.drive.keys.turn}
            guarded |= {joint.position for joint in device.drive.joints.values()}
    for address in sorted(guarded & derived):
        problem = (
            "an interlock, enclosure, STOP, driving or the night goes by it, and it is worked out"
        )
        remedy = "name the signals in its expression there; minus and all combine them"
        yield Finding(_place_of(address), problem, remedy)
