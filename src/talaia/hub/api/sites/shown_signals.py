"""In which units the signals of a site are shown to somebody. Pure."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

from talaia.model.alarms.expression import ExpressionError, parse_expression
from talaia.model.connection import DerivedSource
from talaia.model.derivation.inferred_units import channel_quantities, infer_quantity
from talaia.model.derivation.plan import channel_kinds
from talaia.model.site import SignalType

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.alarms.expression import ValueKind
    from talaia.model.site import Signal, Site
    from talaia.model.units.conversion import Conversion
    from talaia.model.units.quantity import Quantity

__all__ = ["ShownSignals"]

# Of a position: what its numbers of length are in.
_POSITION_UNIT = "m"


class ShownSignals:
    """Conversions for the signals of one site.

    Attributes:
        by_unit: by the unit that values are stored in.

    """

    def __init__(self, site: Site, by_unit: Mapping[str, Conversion]) -> None:
        """Show what is stored in a unit of ``by_unit`` in another one."""
        self.by_unit = by_unit
        self._site = site

    def conversion_of(self, signal: Signal) -> Conversion | None:
        """Tell how a signal is shown; None as it is stored."""
        position = signal.type is SignalType.POSITION
        conversion = self.by_unit.get(_POSITION_UNIT if position else signal.unit)
        if conversion is None or not (position or signal.type is SignalType.NUMBER):
            return None
        if conversion.offset and isinstance(signal.source, DerivedSource):
            # How much warmer it is inside than outside is no temperature: 2 °C are 3.6 °F then.
            conversion = self._convert_derived(signal.source.expression, conversion)
        if conversion is not None and signal.decimals >= 0:
            conversion = conversion._replace(decimals=conversion.digits_for(signal.decimals))
        return conversion

    def _convert_derived(self, expression: str, conversion: Conversion) -> Conversion | None:
        try:
            tree = parse_expression(expression, self._kinds).tree
            parts = [infer_quantity(part, self._quantities) for part in tree.parts]
            if tree.form == "-" and all(part.zero for part in parts):
                return conversion.of_difference()
            # With plain numbers in it nobody knows what scale it is on: shown as it is.
            return conversion if infer_quantity(tree, self._quantities).factor else None
        except ExpressionError:
            # Checked when the description came; what cannot be read has no values, either.
            return None

    @cached_property
    def _kinds(self) -> Mapping[str, ValueKind]:
        return channel_kinds(self._site)

    @cached_property
    def _quantities(self) -> Mapping[str, Quantity]:
        return channel_quantities(self._site)
