"""How the routes of boards are tried: about one's own board, and about another's."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

from talaia.model.boards.board import Board

from .world import SIGNED_IN, holds

if TYPE_CHECKING:
    import httpx

    from .world import World

__all__ = ["BOARD", "changes_board", "kept_board", "reads_board", "shares_board"]

_NUMBERS = itertools.count()
BOARD = {
    "name": "A board",
    "note": "",
    "site": "",
    "kind": "",
    "device": "",
    "tiles": [
        {
            "id": "t1",
            "type": "value",
            "title": "",
            "settings": {"signal": "base/open"},
            "desktop": {"x": 0, "y": 0, "w": 3, "h": 2},
            "phone": None,
        }
    ],
}


async def kept_board(world: World, client: httpx.AsyncClient, about: str) -> str:
    """Keep a board of whoever asks, or of somebody else; give its key."""
    hub = world.hub.hub
    named = (await client.get("/api/me")).json().get("name", "") if about == "own" else ""
    owner = (await world.hub.people.find_by_name(named)).id if named else int(await world.person())
    key = await hub.boards.kept.add_board(
        Board(name=f"Board {next(_NUMBERS)}"), owner, "somebody", ""
    )
    assert key is not None
    return key


def reads_board(actor: str, about: str) -> bool:
    """A script of a person's reads their boards; an admin those of all."""
    return actor == "admin" or (about == "own" and actor in SIGNED_IN)


def changes_board(actor: str, about: str) -> bool:
    """By oneself, and no script."""
    return reads_board(actor, about) and actor != "token"


def shares_board(actor: str, about: str) -> bool:
    """Only who may use something shows others how to look at it."""
    return changes_board(actor, about) and any(
        holds(actor, "use", one) for one in ("agv/base", "agv/power", "agv", "")
    )
