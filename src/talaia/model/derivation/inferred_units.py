"""What unit an expression gives. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.alarms.expression import ExpressionError
from talaia.model.site import PositionFrame, SignalType, parts_of
from talaia.model.units.quantity import PLAIN, Quantity, QuantityMismatch, quantity_of_unit

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.alarms.expression import ExpressionNode
    from talaia.model.site import Signal, Site

__all__ = ["channel_quantities", "infer_quantity"]


def channel_quantities(site: Site) -> dict[str, Quantity]:
    """Tell what each channel measures; a plain number where its unit is not described."""
    return {
        f"{device_id}/{signal_id}" + (f".{part}" if part else ""): _part_quantity(signal, part)
        for device_id, device in site.devices.items()
        for signal_id, signal in device.signals.items()
        for part in parts_of(signal)
    }


def infer_quantity(node: ExpressionNode, channels: Mapping[str, Quantity]) -> Quantity:
    """Tell what an expression measures; a plain number for a condition.

    Raises:
        ExpressionError: units do not go together; with the place of the sign between them.

    """
    # From the inside out: what the parts are in decides what may be done with them.
    parts = [infer_quantity(part, channels) for part in node.parts]
    try:
        match node.form:
            case "signal":
                return channels.get(node.address, PLAIN)
            case "+" | "-":
                return parts[0].plus(parts[1], 1 if node.form == "+" else -1)
            case "*" | "/":
                return parts[0].times(parts[1], 1 if node.form == "*" else -1)
            case "min" | "max" | "compare":
                # All of one unit; which of them is chosen depends on values.
                found = parts[0]
                for part in parts[1:]:
                    found = found.beside(part)
                return PLAIN if node.form == "compare" else found
            case "negate" | "abs":
                return parts[0]
            # A number, a text, or what gives a truth.
            case _:
                return PLAIN
    except QuantityMismatch as error:
        raise ExpressionError(node.at, str(error)) from error


def _part_quantity(signal: Signal, part: str) -> Quantity:
    if signal.type is SignalType.NUMBER:
        return quantity_of_unit(signal.unit)
    if signal.type is not SignalType.POSITION:
        return PLAIN
    # As `parts_of` has them.
    if signal.frame is PositionFrame.WGS84:
        return quantity_of_unit("m" if part == "alt" else "°")
    return quantity_of_unit("rad" if part == "yaw" else "m")
