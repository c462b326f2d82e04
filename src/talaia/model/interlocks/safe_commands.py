"""Which commands of a site only make it safe, so that nothing but their own sense delays them."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from talaia.model.site import Site

__all__ = ["never_asks", "safe_commands"]

# What these are called needs no enclosure to be known as making safe.
_SAFE_NAMES = frozenset({"close", "shut", "stop", "abort", "halt", "park"})


def safe_commands(site: Site) -> frozenset[str]:
    """Give the addresses, ``<device>/<command>``, that close, stop, park or abort for a roof.

    An enclosure names them: ``close``, ``stop``, ``park`` and ``abort``.
    """
    found: set[str] = set()
    for enclosure in site.enclosures.values():
        found.add(enclosure.close.command)
        found.update(step.command for step in enclosure.abort)
        if enclosure.stop:
            found.add(enclosure.stop)
        if enclosure.park is not None:
            found.add(enclosure.park.command)
    return frozenset(found)


def never_asks(site: Site, device: str, command: str) -> bool:
    """Tell whether a command is done whoever else acts on the device: it makes safe."""
    return command in _SAFE_NAMES or f"{device}/{command}" in safe_commands(site)
