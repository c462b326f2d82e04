"""What a page is told of an interlock, by what its person may see and do. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.clock import MS
from talaia.hub.auth.permissions import Right, sees_device
from talaia.model.interlocks.override_rules import longest_override
from talaia.wire.browser import InterlockUpdate

if TYPE_CHECKING:
    from talaia.hub.auth.permissions import Grants
    from talaia.hub.live.sites import LiveSite
    from talaia.model.site import Site

__all__ = ["interlock_news"]


def interlock_news(
    live: LiveSite, name: str, *, grants: Grants, mono_ns: int, wall_ns: int
) -> InterlockUpdate | None:
    """Say how an interlock stands now; none if the description has none of that name.

    Args:
        live: the site.
        name: of the interlock, one that the gateway has told of.
        grants: of the person who is told.
        mono_ns: now, on the clock by which news is heard.
        wall_ns: now (UTC), for when it was locked.

    """
    rule = live.description.interlocks.get(name)
    if rule is None:
        # The gateway may still speak of one that was taken out.
        return None
    state, heard_ns = live.current.interlocks[name]
    # Reasons name values and people: only for those who may view the whole site.
    views = grants.has_right(Right.VIEW, live.name)
    admin = grants.has_right(Right.ADMIN, live.name)
    seen = [command for command in rule.refuse if _sees(live, grants, command)]
    slowed = [command for command in rule.slow if _sees(live, grants, command)]
    passed_ms = (mono_ns - heard_ns) // MS
    # For how long is said by the gateway; since when follows from the hub's own clocks.
    since_us = (wall_ns // MS - state.for_ms - passed_ms) * 1000
    return InterlockUpdate(
        site=live.name,
        interlock=name,
        name=rule.name,
        locked=state.locked,
        unsafe=state.unsafe,
        why=state.why if views else "",
        since_us=since_us if state.locked else 0,
        clears_ms=max(0, state.clears_ms - passed_ms),
        refuses=[_named(live.description, address) for address in seen],
        targets=seen,
        slows=[
            # U+202F is a narrow no-break space: SI has a space before the sign.
            f"{_named(live.description, command)} to {rule.slow[command] * 100:.0f}\u202f%"
            for command in slowed
        ],
        slowed=slowed,
        overridable=longest_override(rule) > 0 and not state.no_override,
        # That it is overridden must be seen by all, by whom only by those who may view.
        overridden_by=state.overridden_by if views or not state.overridden_by else "an admin",
        reason=state.reason if views else "",
        override_ms=max(0, state.override_ms - passed_ms),
        longest_s=longest_override(rule) if admin and not state.no_override else 0.0,
        condition=state.condition if views else "",
        no_override=state.no_override if views else "",
        unknown=state.unknown if views else [],
    )


def _sees(live: LiveSite, grants: Grants, target: str) -> bool:
    """Tell whether a person may know what is locked: as pages list devices and their commands."""
    device_id, _, what = target.partition("/")
    if not sees_device(grants, live.description, device_id):
        return False
    if what == "*":
        return True
    command = what in live.description.devices[device_id].commands
    return grants.has_right(Right.USE if command else Right.VIEW, live.name, device_id)


def _named(site: Site, target: str) -> str:
    """Say what an interlock refuses or slows down, as people call it."""
    device_id, _, what = target.partition("/")
    device = site.devices[device_id]
    if what == "*":
        return f"{device.name}: everything"
    command = device.commands.get(what)
    return f"{device.name}: {command.name if command is not None else 'driving'}"
