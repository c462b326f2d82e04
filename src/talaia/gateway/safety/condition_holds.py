"""Which conditions hold an interlock locked: unsafe now, or not safe for long enough yet. Pure.

The interlock as a whole is `InterlockStateMachine`'s; this says which of its conditions it is,
because only one is overridden at a time, and never one that is unknown.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.model.interlocks.override_rules import (
    condition_id,
    condition_label,
    longest_override,
    never_overridden,
)

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.gateway.safety.interlock_state import InterlockVerdict
    from talaia.model.interlocks.interlock import Interlock
    from talaia.model.site import Site

__all__ = ["ConditionHolds"]


@dataclass(slots=True)
class _Held:
    """Until when a condition holds (ns, monotonic), and whether that was measured."""

    until_ns: int
    measured: bool


class ConditionHolds:
    """All conditions of one interlock, by id, over time."""

    def __init__(self, site: Site, rule: Interlock, now_ns: int) -> None:
        """Begin with all of them unknown, as after a restart."""
        self._rule = rule
        self._dwell_ns = round(rule.dwell * SECOND)
        self._held: dict[str, _Held] = {}
        self._never: dict[str, str] = {}
        self._labels: dict[str, str] = {}
        # Those that could not be judged at the last look, in the order of the description.
        self._unknown: list[str] = []
        for condition in rule.when:
            name = condition_id(condition)
            self._held[name] = _Held(now_ns + self._dwell_ns, measured=False)
            self._labels[name] = condition_label(site, name)
            # Of several limits of one signal one that is never overridden counts for all.
            self._never[name] = self._never.get(name) or never_overridden(site, condition)

    def update_verdicts(
        self, verdicts: Iterable[tuple[str, InterlockVerdict]], now_ns: int
    ) -> None:
        """Take in what each condition says, in the order of the description."""
        seen: set[str] = set()
        self._unknown = []
        for name, verdict in verdicts:
            if not verdict.why:
                continue
            held = self._held[name]
            dwell_ns = self._dwell_ns if verdict.dwell is None else round(verdict.dwell * SECOND)
            # Of several limits of one signal any that is unknown makes all of it unknown.
            measured = not verdict.unknown and (held.measured or name not in seen)
            held.until_ns, held.measured = max(held.until_ns, now_ns + dwell_ns), measured
            seen.add(name)
            if verdict.unknown and name not in self._unknown:
                self._unknown.append(name)

    @property
    def unknown(self) -> list[str]:
        """Give those that could not be judged at the last look."""
        return list(self._unknown)

    def holding_conditions(self, now_ns: int) -> list[str]:
        """Give those that are not safe for long enough."""
        return [name for name, held in self._held.items() if now_ns < held.until_ns]

    def was_measured(self, name: str) -> bool:
        """Tell whether what was last unsafe of a condition was measured, and not merely unknown."""
        return name in self._held and self._held[name].measured

    def locking_condition(self, now_ns: int) -> str:
        """Give the condition that locks now, the first of several; while locked there is one."""
        holding = self.holding_conditions(now_ns)
        if holding:
            return holding[0]
        return max(self._held, key=lambda name: self._held[name].until_ns, default="")

    def override_problem(self, name: str, now_ns: int) -> str:
        """Say why a condition may not be overridden while the interlock is locked, if so."""
        if not longest_override(self._rule):
            return f"{self._rule.name} may never be overridden"
        if name not in self._held:
            known = ", ".join(self._held)
            return f"{self._rule.name} has no condition {name!r}; it has {known}"
        label, locking = (
            self._labels[name],
            self.holding_conditions(now_ns) or [self.locking_condition(now_ns)],
        )
        if name not in locking:
            return f"{label} locks nothing now; {self._labels[locking[0]]} does"
        if self._never[name]:
            return f"{label}: {self._never[name]}"
        others = [other for other in locking if other != name]
        if others:
            return (
                f"{self._labels[others[0]]} locks as well as {label}, "
                "and only one condition at a time is overridden"
            )
        if not self._held[name].measured:
            return f"{label} is or was unknown, and what is unknown is never overridden"
        return ""

    def override_end(self, name: str, now_ns: int) -> str:
        """Say why the override of a condition has to end, if so."""
        if not self.was_measured(name):
            return f"{self._labels[name]} is unknown"
        others = [other for other in self.holding_conditions(now_ns) if other != name]
        return f"{self._labels[others[0]]} locks as well" if others else ""
