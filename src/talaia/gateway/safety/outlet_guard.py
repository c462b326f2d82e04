"""Says why an outlet may not be switched off: a safe state still needs what it feeds. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.interlocks.outlet_needs import needs_of, outlets_cut
from talaia.model.site import DeviceKind

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.gateway.ports import Field
    from talaia.model.interlocks.enclosure import Enclosure, Sighting
    from talaia.model.interlocks.outlet_needs import Need
    from talaia.model.site import Site

    Sighted = Callable[[Sighting], bool | None]

__all__ = ["refuse_power_cut"]

_SAFE = {DeviceKind.DOME: "closed", DeviceKind.TELESCOPE: "parked"}


def refuse_power_cut(
    *, site: Site, device: str, command: str, args: Mapping[str, Field], sighted: Sighted
) -> str:
    """Say why a command may not be done because it takes power that is needed; empty if it may.

    Args:
        site: the description.
        device: whose command it is.
        command: its name.
        args: its arguments, by name.
        sighted: tells whether a sensor says so; none when it says nothing, which counts as needed.

    """
    described = site.devices.get(device)
    if described is None:
        return ""
    for outlet in outlets_cut(described, command, args):
        for fed in described.outlets[outlet].feeds:
            if why := _fed_is_needed(site, fed, sighted):
                return f"{site.devices[fed].name} needs its power: {why}"
    return ""


def _fed_is_needed(site: Site, fed: str, sighted: Sighted) -> str:
    needs = [*needs_of(site, fed)]
    for need in needs:
        if why := _need_reason(site.enclosures[need.enclosure], need, sighted):
            return why
    # No enclosure names it, so no sensor could say that it is safe: refused until somebody
    # describes that.
    safe = _SAFE.get(site.devices[fed].kind)
    if safe is not None and not needs:
        return f"nothing says when it is {safe}; describe an enclosure that names it"
    return ""


def _need_reason(rule: Enclosure, need: Need, sighted: Sighted) -> str:
    """Say why it is needed; empty when it is certainly not."""
    if not need.roof:
        # None and False count alike: what is not certainly safe still needs its power.
        parked = None if rule.parked is None else sighted(rule.parked)
        # `closed` has to be said by all sensors; one that is silent keeps the power on.
        return "" if parked else f"it is {_certainty_words(parked)} parked"
    if any(sighted(sensor) for sensor in rule.moving):
        return f"{rule.name} moves"
    closed = [sighted(sensor) for sensor in rule.closed]
    if closed and all(closed):
        return ""
    return f"{rule.name} is {_certainty_words(None if None in closed else False)} closed"


def _certainty_words(said: bool | None) -> str:  # noqa: FBT001 - what a sensor says
    return "not known to be" if said is None else "not"
