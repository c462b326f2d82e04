"""How the routes of missions are tried: about a mission of each site."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

from talaia.model.missions.mission import Mission, MissionStep, StepKind

if TYPE_CHECKING:
    from .world import World

__all__ = ["MISSION", "kept_mission"]

_NUMBERS = itertools.count()
_STEP = {
    "kind": "pause", "name": "", "device": "", "command": "", "args": {}, "units": {},
    "condition": "", "seconds": 1.0, "goes_on": False,
}  # fmt: skip
MISSION = {"mission": {"name": "Patrol", "note": "", "steps": [_STEP], "schedule": None}}


async def kept_mission(world: World, site: str) -> str:
    """Keep a mission of a site; give its number.

    Nothing is heard of its device there, so whoever may begin it is told that it is stale.
    """
    owner = int(await world.person())
    device = {"agv": "base", "moon": "rover"}[site]
    step = MissionStep(kind=StepKind.COMMAND, device=device, command="turn")
    mission = Mission(name=f"Mission {next(_NUMBERS)}", steps=(step,))
    number = await world.hub.hub.missions.store.add_mission(site, mission, owner, 0)
    assert number is not None
    return str(number)
