"""Alarms that a site with an enclosure has without describing them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.alarms.alarm import Alarm, AlarmKind, Severity

if TYPE_CHECKING:
    from talaia.model.site import Site

__all__ = ["standard_alarms"]

# While nobody has acknowledged it; see `Alarm`.
REPEAT_S = 300.0
# While it is acknowledged and goes on.
REMIND_S = 1800.0
# A link that is lost for less raises nothing.
GATEWAY_SILENT_S = 60.0


def standard_alarms(site: Site) -> dict[str, Alarm]:
    """Give them by short name: one for each enclosure, and one for a gateway without a link.

    An alarm of the description that is of the same kind, and of the same enclosure or of all of
    them, stands in the place of the standard one; so does one of the same short name.
    """
    alarms: dict[str, Alarm] = {}
    described = site.alarms.values()
    # An empty name means all enclosures.
    of = {alarm.enclosure for alarm in described if alarm.kind is AlarmKind.ENCLOSURE}
    for name, enclosure in site.enclosures.items():
        if name not in of and "" not in of:
            alarms[f"{name}_not_closed"] = Alarm(
                name=f"{enclosure.name} NOT CLOSED",
                kind=AlarmKind.ENCLOSURE,
                enclosure=name,
                severity=Severity.CRITICAL,
                repeat=REPEAT_S,
                remind=REMIND_S,
                advice="Its sensors disagree, or say that it is not closed though it must be."
                " See how it stands, and close it by hand.",
            )
    if site.enclosures and not any(alarm.kind is AlarmKind.GATEWAY for alarm in described):
        alarms["gateway_silent"] = Alarm(
            name="Gateway silent",
            kind=AlarmKind.GATEWAY,
            severity=Severity.CRITICAL,
            delay=GATEWAY_SILENT_S,
            repeat=REPEAT_S,
            remind=REMIND_S,
            advice="Nothing is known of the site. See from elsewhere whether it is closed.",
        )
    return {name: alarm for name, alarm in alarms.items() if name not in site.alarms}
