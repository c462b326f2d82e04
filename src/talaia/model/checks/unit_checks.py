"""What a unit must look like, and what is worth a note about one. Any unit may be written."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from talaia.model.checks.identifiers import Finding, is_unseen
from talaia.model.units.conversion import conversion_between, likely_unit, units_like
from talaia.model.units.unit_text import LONGEST_UNIT, measure_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from talaia.model.site import Site

__all__ = ["shown_units_findings", "unit_fits", "unit_notes"]


# Units of their own, which people write where a sign is missing.
_MISTAKEN = {"C": ("coulomb", "°C"), "F": ("farad", "°F")}
# By what its device or signal is called.
_ACCELERATION = re.compile(r"accel|vibration|shock|\.imu\.")


def unit_fits(where: str, unit: str) -> Iterator[Finding]:
    """Any text that can be shown beside a number."""
    if len(unit) > LONGEST_UNIT or unit != unit.strip() or any(map(is_unseen, unit)):
        yield Finding(
            where,
            f"expected a unit of at most {LONGEST_UNIT} characters that can all be seen, "
            f"found {unit[: 2 * LONGEST_UNIT]!r}",
            "write its symbol, like m/s or °C",
        )


def unit_notes(site: Site) -> Iterator[Finding]:
    """Name each unit that nobody knows, once: it is shown as written and cannot be converted."""
    told: set[str] = set()
    for where, unit in _written_units(site):
        if unit == "g" and _ACCELERATION.search(where):
            problem = "the unit 'g' is the gram, and this is an acceleration"
            yield Finding(where, problem, "did you mean 'gₙ', which is 9.80665 m/s²?")
            continue
        if not unit or unit in told:
            continue
        told.add(unit)
        if unit in _MISTAKEN:
            read, meant = _MISTAKEN[unit]
            yield Finding(where, f"the unit {unit!r} is the {read}", f"did you mean {meant!r}?")
            continue
        if measure_of(unit) is not None:
            continue
        meant = likely_unit(unit)
        remedy = f"did you mean {meant!r}?" if meant else "nothing is to be done if it is meant so"
        problem = f"the unit {unit!r} is shown as written; Talaia does not know what it measures"
        yield Finding(where, problem, remedy)


def shown_units_findings(where: str, shown: Mapping[str, str]) -> Iterator[Finding]:
    """Units that measure the same, on both sides."""
    for stored, wanted in shown.items():
        at = f"{where}.{stored}"
        yield from unit_fits(at, stored)
        yield from unit_fits(at, wanted)
        if conversion_between(stored, wanted) is None:
            like = ", ".join(units_like(stored)[:8])
            yield Finding(
                at,
                f"{stored!r} cannot be shown in {wanted!r}",
                f"take one of: {like}" if like else "leave it out: nobody knows what it measures",
            )


def _written_units(site: Site) -> Iterator[tuple[str, str]]:
    for device_id, device in site.devices.items():
        for signal_id, signal in device.signals.items():
            yield f"$.devices.{device_id}.signals.{signal_id}.unit", signal.unit
        for command_id, command in device.commands.items():
            at = f"$.devices.{device_id}.commands.{command_id}.arguments"
            for argument_id, argument in command.arguments.items():
                yield f"{at}.{argument_id}.unit", argument.unit
