"""How the routes of notes are tried: about what somebody else has written of a device or a site."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.store.sites.notes import NoteBody

from .world import NOW, holds

if TYPE_CHECKING:
    from .world import World

__all__ = ["NOTED", "VIEWED", "kept_note", "manages_noted", "note_of", "uses_noted"]

NOTED = ("agv", "agv/base", "agv/power", "moon", "moon/rover")
# Where what is seen may be viewed, too: a note on the rest is not there for who only sees.
VIEWED = ("agv/power", "moon/rover")


def uses_noted(actor: str, about: str) -> bool:
    """Who uses it writes about it."""
    return holds(actor, "use", about)


def manages_noted(actor: str, about: str) -> bool:
    """Of what others wrote an admin alone changes something."""
    return holds(actor, "admin", about)


def note_of(about: str) -> dict[str, object]:
    """Give a note about a site or a device."""
    device = about.partition("/")[2]
    return {"device": device, "signal": "", "from_us": NOW, "to_us": NOW, "text": "written"}


async def kept_note(world: World, about: str) -> dict[str, str]:
    """Keep a note of somebody whom no test signs in as; give what its address holds."""
    site, _, device = about.partition("/")
    author = int(await world.person())
    body = NoteBody(device, "", NOW, NOW, "theirs")
    kept = await world.hub.hub.notes.store.add_note(site, body, author, "somebody")
    assert kept is not None
    return {"site": site, "note": str(kept.id)}
