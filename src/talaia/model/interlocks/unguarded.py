"""Says plainly which roofs and telescopes nothing keeps safe. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.site import DeviceKind

if TYPE_CHECKING:
    from talaia.model.site import Site

__all__ = ["unguarded_devices", "unguarded_notice"]

# Rain and wind reach these.
_UNDER_THE_SKY = frozenset({DeviceKind.DOME, DeviceKind.TELESCOPE})


def unguarded_devices(site: Site) -> tuple[str, ...]:
    """Give the domes and telescopes, by short name, that nothing closes or parks by itself.

    Each is judged by itself: it needs an enclosure that closes or parks it, or an interlock that
    runs a command of it.
    """
    guarded: set[str] = set()
    for roof in site.enclosures.values():
        steps = [roof.close, *([] if roof.park is None else [roof.park])]
        steps += [part.close for part in roof.parts().values() if part.close is not None]
        guarded |= {step.command.partition("/")[0] for step in steps}
    for rule in site.interlocks.values():
        guarded |= {step.command.partition("/")[0] for step in rule.run}
    return tuple(
        name
        for name, device in site.devices.items()
        if device.kind in _UNDER_THE_SKY and name not in guarded
    )


def unguarded_notice(site: Site) -> str:
    """Say which domes and telescopes nothing keeps safe, and how to change it; empty if none."""
    names = [site.devices[name].name for name in unguarded_devices(site)]
    if not names:
        return ""
    # Whole sentences, not pieces of one: pages know them by their words in other languages.
    if len(names) == 1:
        lacks = _what_is_missing(site, "no enclosure of the description is about it")
        return (
            f"{names[0]} does not close or park by itself: {lacks}. In rain, in wind or without "
            "weather data only a person closes or parks it. `talaia docs interlocks` says how to "
            "change that."
        )
    who = f"{', '.join(names[:-1])} and {names[-1]}"
    lacks = _what_is_missing(site, "no enclosure of the description is about them")
    return (
        f"{who} do not close or park by themselves: {lacks}. In rain, in wind or without weather "
        "data only a person closes or parks them. `talaia docs interlocks` says how to change that."
    )


def _what_is_missing(site: Site, of_others: str) -> str:
    """Say what is missing; ``of_others`` where there is an enclosure of something else."""
    if site.enclosures:
        return of_others
    if site.interlocks:
        return "the description's interlocks close no roof, and it has no enclosure"
    return "the description has no interlocks and no enclosure"
