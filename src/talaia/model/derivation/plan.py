"""In which order signals over signals are worked out, and why some cannot be. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.model.alarms.expression import (
    Expression,
    ExpressionError,
    ValueKind,
    parse_expression,
)
from talaia.model.derivation.source import DerivedSource
from talaia.model.site import SignalType, parts_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.site import Signal, Site

__all__ = ["DerivedSignal", "channel_kinds", "derived_addresses", "find_cycle", "plan_derivations"]


class DerivedSignal(NamedTuple):
    """A signal that is worked out, and how.

    Attributes:
        address: ``device/signal``.
        expression: over channels.

    """

    address: str
    signal: Signal
    expression: Expression


def channel_kinds(site: Site) -> dict[str, ValueKind]:
    """Tell what each channel is in an expression: a state compares as the text of its name."""
    return {
        f"{device_id}/{signal_id}" + (f".{part}" if part else ""): (
            ValueKind.NUMBER
            if signal.type in {SignalType.NUMBER, SignalType.POSITION}
            else ValueKind.TEXT
        )
        for device_id, device in site.devices.items()
        for signal_id, signal in device.signals.items()
        for part in parts_of(signal)
    }


def derived_addresses(site: Site) -> frozenset[str]:
    """Name the signals that are worked out from others."""
    return frozenset(
        f"{device_id}/{signal_id}"
        for device_id, device in site.devices.items()
        for signal_id, signal in device.signals.items()
        if isinstance(signal.source, DerivedSource)
    )


def plan_derivations(site: Site) -> list[DerivedSignal]:
    """List a site's derived signals, each behind those that it is worked out from.

    What cannot be read, or is worked out from itself, is left out: `check` says so.
    """
    kinds = channel_kinds(site)
    parsed: dict[str, DerivedSignal] = {}
    # Sorted, so that the order does not go by the file's.
    for address in sorted(derived_addresses(site)):
        signal = site.signal(address)
        if signal is None or not isinstance(signal.source, DerivedSource):
            continue
        try:
            expression = parse_expression(signal.source.expression, kinds)
        except ExpressionError:
            continue
        parsed[address] = DerivedSignal(address, signal, expression)
    needs = {address: _derived_inputs(derived, parsed) for address, derived in parsed.items()}
    ordered: list[DerivedSignal] = []
    done: set[str] = set()
    # Each turn adds at least one, or what is left goes in circles.
    while ready := [a for a in parsed if a not in done and done.issuperset(needs[a])]:
        ordered += [parsed[address] for address in ready]
        done.update(ready)
    return ordered


def find_cycle(needs: Mapping[str, tuple[str, ...]], begin: str) -> tuple[str, ...]:
    """Give the way from a signal back to itself, itself at both ends; empty if there is none."""
    # By the signal from which each was reached; breadth first, so that the way is the shortest.
    came_from: dict[str, str] = {}
    reached = [begin]
    for address in reached:
        for needed in needs.get(address, ()):
            if needed == begin:
                way = [begin]
                while address != begin:
                    way.append(address)
                    address = came_from[address]
                return tuple(reversed([*way, begin]))
            if needed not in came_from:
                came_from[needed] = address
                reached.append(needed)
    return ()


def _derived_inputs(derived: DerivedSignal, parsed: Mapping[str, DerivedSignal]) -> tuple[str, ...]:
    return tuple(address for address in derived.expression.signals if address in parsed)
