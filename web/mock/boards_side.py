"""Boards of the mock: kept in memory, by the hub's own words for files."""

from __future__ import annotations

import secrets
import time
from typing import TYPE_CHECKING, Any

from fastapi import APIRouter, Request
from fastapi.responses import JSONResponse

from talaia.hub.api.schemas.tile_schemas import BoardShape
from talaia.hub.api.sites.boards import _board_of, _shape_of
from talaia.model.boards.board_file import dump_board, load_board
from talaia.model.errors import DescriptionError

if TYPE_CHECKING:
    from collections.abc import Callable

MISSING = JSONResponse({"code": "unknown", "message": "there is no such board"}, 404)


def router(person_of: Callable[[Request], str]) -> APIRouter:
    """Give the routes; ``person_of`` names who asks."""
    routes = APIRouter(default_response_class=JSONResponse)
    boards: dict[str, dict[str, Any]] = {}

    def row_of(key: str, who: str) -> dict[str, Any]:
        kept = boards[key]
        board = kept["versions"][-1]["board"]
        mine = who in (kept["owner"], "admin")
        return {
            "key": key, "name": board["name"], "site": board["site"], "kind": board["kind"],
            "described": False, "owner": kept["owner"], "share": kept["share"], "role": "",
            "number": len(kept["versions"]), "tiles": len(board["tiles"]),
            "changed_us": kept["versions"][-1]["time_us"], "may_change": mine, "may_share": mine,
        }  # fmt: skip

    def save(key: str, board: dict[str, Any], who: str, note: str) -> dict[str, Any]:
        kept = boards.setdefault(key, {"owner": who, "share": "own", "versions": []})
        said = {"board": board, "time_us": int(time.time() * 1e6), "who": who, "note": note}
        kept["versions"].append(said)
        return {"key": key, "number": len(kept["versions"])}

    @routes.get("/api/tiles")
    async def tiles() -> dict[str, Any]:
        return {"api": 1, "tiles": [], "broken": []}

    @routes.get("/api/boards")
    async def overview(request: Request) -> dict[str, Any]:
        return {"boards": [row_of(key, person_of(request)) for key in boards]}

    @routes.post("/api/boards")
    async def add(request: Request) -> dict[str, Any]:
        asked = await request.json()
        return save(secrets.token_hex(8), asked["board"], person_of(request), asked.get("note", ""))

    @routes.post("/api/boards/text")
    async def text(request: Request) -> dict[str, Any]:
        shape = BoardShape.model_validate((await request.json())["board"])
        return {"text": dump_board(_board_of(shape))}

    @routes.post("/api/boards/reading")
    async def reading(request: Request) -> dict[str, Any]:
        try:
            board = load_board((await request.json())["text"])
        except DescriptionError as error:
            return {
                "board": None,
                "where": error.where,
                "problem": error.problem,
                "remedy": error.remedy,
            }
        shape = _shape_of(board).model_dump(mode="json")
        return {"board": shape, "where": "", "problem": "", "remedy": ""}

    @routes.get("/api/boards/{key}", response_model=None)
    async def detail(key: str, request: Request) -> JSONResponse | dict[str, Any]:
        if key not in boards:
            return MISSING
        row = row_of(key, person_of(request))
        board = boards[key]["versions"][-1]["board"]
        return {"row": row, "number": row["number"], "board": board}

    @routes.put("/api/boards/{key}", response_model=None)
    async def change(key: str, request: Request) -> JSONResponse | dict[str, Any]:
        asked = await request.json()
        return save(key, asked["board"], person_of(request), asked.get("note", ""))

    @routes.delete("/api/boards/{key}", status_code=204)
    async def remove(key: str) -> None:
        boards.pop(key, None)

    @routes.put("/api/boards/{key}/share", status_code=204)
    async def share(key: str, request: Request) -> None:
        boards[key]["share"] = (await request.json())["share"]

    @routes.put("/api/boards/{key}/public", status_code=204)
    async def publish(key: str) -> None:
        boards[key]["share"] = "public"

    @routes.get("/api/boards/{key}/versions")
    async def versions(key: str) -> dict[str, Any]:
        kept = list(enumerate(boards[key]["versions"], 1))
        said = ("time_us", "who", "note")
        return {
            "versions": [
                {"number": number, **{name: version[name] for name in said}}
                for number, version in reversed(kept)
            ]
        }

    @routes.post("/api/boards/{key}/versions/{number}/restore")
    async def restore(key: str, number: int, request: Request) -> dict[str, Any]:
        before = boards[key]["versions"][number - 1]["board"]
        return save(key, before, person_of(request), f"back to version {number}")

    return routes
