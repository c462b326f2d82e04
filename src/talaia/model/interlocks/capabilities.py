"""What an enclosure can do, as it is described or as it follows from what is described of it."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from talaia.model.interlocks.enclosure import Enclosure
    from talaia.model.site import Site

__all__ = ["Capabilities", "capabilities_of"]


@dataclass(frozen=True, slots=True)
class Capabilities:
    """See `EnclosureCapabilities`; nothing is left open here."""

    has_shutter: bool
    can_rotate: bool
    segments: int
    can_partial: bool
    has_flap: bool


def capabilities_of(site: Site, enclosure: Enclosure) -> Capabilities:
    """Say what an enclosure can do."""
    said = enclosure.capabilities
    follows = Capabilities(
        has_shutter=True,
        # What is described as an enclosure closes.
        can_rotate=enclosure.follow is not None or _can_turn(site, enclosure),
        segments=max(1, len(enclosure.segments)),
        can_partial=bool(
            enclosure.stop
            or enclosure.position
            or any(segment.position for segment in enclosure.segments.values())
        ),
        has_flap=enclosure.flap is not None,
    )
    if said is None:
        return follows
    # What is said wins over what follows.
    known = {key: getattr(said, key) for key in asdict(follows)}
    return replace(follows, **{key: value for key, value in known.items() if value is not None})


def _can_turn(site: Site, enclosure: Enclosure) -> bool:
    """Tell whether the device that closes has a command that takes an angle."""
    device = site.devices.get(enclosure.close.command.partition("/")[0])
    commands = {} if device is None else device.commands
    return any(
        argument.unit == "°"
        for command in commands.values()
        for argument in command.arguments.values()
    )
