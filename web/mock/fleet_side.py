"""Home, the fleet and missions: a few sites beside the made-up vehicle, and one run.

Rows are made by the hub's own schemas: a field that is new there fails here, and not in a page.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

from described import site_json
from fastapi import APIRouter, Request, Response

from talaia.hub.api.missions.fleet_schemas import SharedCommandList
from talaia.hub.api.missions.mission_schemas import (
    MissionList,
    MissionRow,
    MissionRunList,
    MissionRunShape,
)
from talaia.hub.api.schemas.common import SiteSummary

if TYPE_CHECKING:
    from world import World

USES = [{"right": "use", "site": "*", "device": "*"}]
OTHERS = (
    ("dome", "Observatory dome", "", (), 7500, ()),
    ("bruno", "Bruno", "Warehouse north", ("indoor", "forklift"), 0, ("base",)),
    ("clara", "Clara", "Warehouse north", ("indoor",), 0, ("base",)),
)


def fleet_rows(world: World) -> list[dict[str, Any]]:
    """List the made-up vehicle and some others, one of them away."""
    site = world.site
    signals = sum(len(device.signals) for device in site.devices.values())
    own = SiteSummary(
        site=site.site, name=site.name, zone=site.zone, online=world.online,
        since_us=int(world.since * 1e6),
        last_seen_us=int((time.time() if world.online else world.since) * 1e6),
        why="" if world.online else "the gateway closed the link",
        loop_ms=4.2, skew_ms=0.0, rival_us=0, devices=len(site.devices), signals=signals, stale=0,
        group="", tags=["indoor"], state="Wander mode: on" if world.wandering else "",
        battery=74.0, latitude=41.3874 + world.y / 111_320, longitude=2.1686 + world.x / 83_500,
        moving=abs(world.linear) > 0.01, heading=None, driver=world.holder, stream="camera/front",
        stops=["base"],
    )  # fmt: skip
    rows = [own]
    for name, said, group, tags, away_s, stops in OTHERS:
        since = int((time.time() - away_s if away_s else world.since) * 1e6)
        rows.append(
            own.model_copy(
                update={
                    "site": name, "name": said, "group": group, "tags": list(tags),
                    "online": not away_s, "since_us": since, "last_seen_us": since,
                    "why": "the gateway closed the link" if away_s else "", "stream": "",
                    "stops": list(stops), "driver": "", "battery": None, "state": "",
                }
            )
        )  # fmt: skip
    return [row.model_dump(mode="json") for row in rows]


class MadeMissions:
    """Missions that are kept while the mock runs; a run goes on for three seconds a step."""

    STEP_S = 3.0

    def __init__(self) -> None:
        """Keep none yet."""
        self.rows: dict[str, dict[str, Any]] = {}
        self.runs: list[tuple[float, str, dict[str, Any]]] = []

    def run_at(self, began: float, number: str, mission: dict[str, Any]) -> MissionRunShape:
        """Say how far a run is."""
        over = (time.time() - began) / self.STEP_S
        steps = [
            {
                "name": step["name"] or step["condition"] or step["command"] or "wait",
                "state": _state_of(over - at), "message": "", "began_us": 0, "ended_us": 0,
            }
            for at, step in enumerate(mission["steps"])
        ]  # fmt: skip
        return MissionRunShape.model_validate(
            {
                "id": f"{began}", "mission": number, "name": mission["name"], "who": "operator",
                "begun_by": "operator", "why": "", "began_us": int(began * 1e6), "ended_us": 0,
                "state": "succeeded" if over > len(steps) else "running", "steps": steps,
            }
        )  # fmt: skip

    def listed_runs(self) -> list[MissionRunShape]:
        """Give all runs, the newest first."""
        return [self.run_at(*run) for run in reversed(self.runs)]


def _state_of(over: float) -> str:
    if over >= 1:
        return "succeeded"
    return "running" if over >= 0 else "waiting"


def fleet_router(world: World) -> APIRouter:
    """Answer for the fleet and for missions."""
    router, made = APIRouter(), MadeMissions()

    @router.get("/api/commands")
    async def commands() -> dict[str, Any]:
        found = [
            {
                "device": device["id"], "device_name": device["name"], "command": command,
                "sites": [world.site.site, "bruno", "clara"], "barred": [],
            }
            for device in site_json(world, USES)["devices"]
            for command in device["commands"]
        ]  # fmt: skip
        return SharedCommandList.model_validate({"commands": found}).model_dump(mode="json")

    @router.get("/api/sites/{name}/missions")
    async def missions() -> dict[str, Any]:
        going = [run for run in made.listed_runs() if run.state == "running"]
        rows = [MissionRow.model_validate(row) for row in made.rows.values()]
        return MissionList(missions=rows, run=next(iter(going), None)).model_dump(mode="json")

    @router.post("/api/sites/{name}/missions")
    async def add(request: Request) -> dict[str, str]:
        number = f"{len(made.rows) + 1}"
        made.rows[number] = {
            "id": number, "mission": (await request.json())["mission"], "owner": "operator",
            "due_us": 0, "changed_us": int(time.time() * 1e6), "problem": "",
        }  # fmt: skip
        return {"id": number}

    @router.put("/api/sites/{name}/missions/{number}")
    async def change(number: str, request: Request) -> Response:
        made.rows[number]["mission"] = (await request.json())["mission"]
        return Response(status_code=204)

    @router.delete("/api/sites/{name}/missions/{number}")
    async def remove(number: str) -> Response:
        made.rows.pop(number, None)
        return Response(status_code=204)

    @router.post("/api/sites/{name}/missions/{number}/start")
    async def start(number: str) -> dict[str, str]:
        made.runs.append((time.time(), number, made.rows[number]["mission"]))
        return {"id": f"{made.runs[-1][0]}"}

    @router.get("/api/sites/{name}/mission-runs")
    async def runs() -> dict[str, Any]:
        return MissionRunList(runs=made.listed_runs()).model_dump(mode="json")

    @router.post("/api/sites/{name}/mission-runs/act")
    async def act() -> Response:
        made.runs.clear()
        return Response(status_code=204)

    return router
