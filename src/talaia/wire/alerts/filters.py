"""Which notices become rapid requests: filters that say why not, so that one can try them. Pure."""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.wire.alerts.notice import NoticeRole

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.wire.alerts.notice import AlertNotice

__all__ = ["AlertFilter", "FilterVerdict", "preview_filter"]


class AlertFilter(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a notice must be.

    Attributes:
        sources: patterns of its source (``*gcn*``), any of which must fit; empty takes all.
        roles: its role; tests are asked for by name, or never become anything.
        largest_error: its place must be known so well (degrees); 0 takes any place.
        declinations: lowest and highest declination (degrees).
        least: by parameter, the least number it may have.
        most: by parameter, the greatest.
        equal: by parameter, patterns of which one must fit.

    """

    sources: tuple[str, ...] = ()
    roles: tuple[str, ...] = (NoticeRole.OBSERVATION,)
    largest_error: float = 0.0
    declinations: tuple[float, float] = (-90.0, 90.0)
    least: dict[str, float] = {}
    most: dict[str, float] = {}
    equal: dict[str, tuple[str, ...]] = {}

    def refusal(self, notice: AlertNotice) -> str:
        """Say why a notice does not pass; empty when it does."""
        if notice.retracts:
            return "it takes its event back"
        if notice.role not in self.roles:
            return f"its role is {notice.role}, not {' or '.join(self.roles)}"
        if self.sources and not any(fnmatchcase(notice.source, one) for one in self.sources):
            return f"it comes from {notice.source or 'nobody'}"
        if notice.ra is None or notice.dec is None:
            return "it names no place"
        low, high = self.declinations
        if not low <= notice.dec <= high:
            return f"its declination is {notice.dec:.1f}°, not within {low:g}° and {high:g}°"
        if self.largest_error and notice.error_radius is None:
            return "it does not say how well its place is known"
        if self.largest_error and (notice.error_radius or 0.0) > self.largest_error:
            return f"its place is known to {notice.error_radius:g}° only"
        return self._parameter_refusal(notice)

    def acceptance(self, notice: AlertNotice) -> str:
        """Say by what a notice that is not refused has passed."""
        met = [f"its role is {notice.role}"]
        if self.sources:
            met.append(f"it comes from {notice.source}")
        if self.declinations != (-90.0, 90.0):
            met.append(f"its declination is {notice.dec:.1f}°")
        if self.largest_error:
            met.append(f"its place is known to {notice.error_radius:g}°")
        named = (*self.equal, *self.least, *self.most)
        met += [f"{name} is {notice.parameters.get(name, '')}" for name in dict.fromkeys(named)]
        return ", ".join(met)

    def _parameter_refusal(self, notice: AlertNotice) -> str:
        for name, patterns in self.equal.items():
            value = notice.parameters.get(name, "")
            if not any(fnmatchcase(value, pattern) for pattern in patterns):
                return f"{name} is {value or 'not told'}, not {' or '.join(patterns)}"
        for limits, words, beyond in ((self.least, "at least", -1), (self.most, "at most", 1)):
            for name, limit in limits.items():
                try:
                    value_number = float(notice.parameters.get(name, ""))
                except ValueError:
                    return f"{name} is no number"
                # Written so that NaN is refused as well.
                if not (value_number - limit) * beyond <= 0:
                    return f"{name} is {value_number:g}, not {words} {limit:g}"
        return ""


class FilterVerdict(NamedTuple):
    """What a filter says of a notice; the reason is empty where it passes."""

    notice: AlertNotice
    refusal: str


def preview_filter(chosen: AlertFilter, notices: Iterable[AlertNotice]) -> list[FilterVerdict]:
    """Try a filter on notices that came before; the same notice counts once."""
    seen: dict[str, AlertNotice] = {}
    for notice in notices:
        seen.setdefault(notice.id, notice)
    return [FilterVerdict(notice, chosen.refusal(notice)) for notice in seen.values()]
