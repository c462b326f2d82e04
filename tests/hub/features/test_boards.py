"""Boards at the hub: versions, sharing, files and descriptions, over its routes."""

from __future__ import annotations

import pytest

from talaia.clock import SystemClock
from talaia.hub.store.accounts.people import People
from talaia.hub.store.sites.boards import Boards
from talaia.model.boards.board import Board
from talaia.model.boards.board_file import load_board
from talaia.model.errors import DescriptionError

from ..conftest import DESCRIPTION, PASSWORD
from ..everyone.boards import BOARD

DESCRIBED = """
boards:
  overview:
    name: Overview
    tiles:
      - type: value
        settings: {signal: base/speed}
  lobby:
    name: Lobby
    share: public
"""


async def made(client, **more: object) -> str:
    answer = await client.post("/api/boards", json={"board": {**BOARD, **more}})
    assert answer.status_code == 200, answer.text
    return answer.json()["key"]


async def names(client) -> list[str]:
    return [row["name"] for row in (await client.get("/api/boards")).json()["boards"]]


async def test_a_version_is_restored_as_a_new_one_and_nothing_is_lost(hub) -> None:
    operator = await hub.client("operator")
    key = await made(operator)
    at = f"/api/boards/{key}"
    renamed = {**BOARD, "name": "Another", "tiles": []}
    saved = await operator.put(at, json={"board": renamed, "base": 1, "note": "emptied"})
    assert saved.json() == {"key": key, "number": 2}
    assert (await operator.post(f"{at}/versions/1/restore", json={"base": 2})).json()["number"] == 3
    now = (await operator.get(at)).json()
    assert (now["board"], now["row"]["number"]) == (BOARD, 3)
    said = [
        (version["number"], version["who"], version["note"])
        for version in (await operator.get(f"{at}/versions")).json()["versions"]
    ]
    assert said == [
        (3, "operator", "back to version 1"),
        (2, "operator", "emptied"),
        (1, "operator", ""),
    ]
    # The second of two who arrange at once is told, instead of undoing what the first did.
    late = await operator.put(at, json={"board": renamed, "base": 2})
    assert (late.status_code, late.json()["code"]) == (409, "changed")


async def test_a_board_is_seen_by_those_it_is_shared_with_and_changed_by_its_owner(hub) -> None:
    operator, guest, admin = [await hub.client(name) for name in ("operator", "guest", "admin")]
    key = await made(operator, name="Mine", site="agv")
    at = f"/api/boards/{key}"
    assert "Mine" not in await names(guest)
    assert (await guest.get(at)).status_code == 404
    assert "Mine" in await names(admin)
    # A guest sees what is public of the site, and has not the right view there.
    assert (await operator.put(f"{at}/share", json={"share": "view"})).status_code == 204
    assert (await guest.get(at)).status_code == 404
    assert (await operator.put(f"{at}/public", json={})).status_code == 403
    foreign = await operator.put(f"{at}/share", json={"share": "role", "role": "guest"})
    assert foreign.status_code == 403
    assert (await admin.put(f"{at}/public", json={})).status_code == 204
    assert (await guest.get(at)).json()["row"]["may_change"] is False
    assert (await guest.put(at, json={"board": BOARD, "base": 1})).status_code == 403
    # The board is open; what its tiles show is not, for that.
    channel = {"channel": "base/turn_rate", "from_us": 0, "to_us": 1}
    assert (await guest.get("/api/sites/agv/history", params=channel)).status_code == 404
    kinds = [row["kind"] for row in (await admin.get("/api/audit")).json()["rows"]]
    assert kinds.count("board shared") == 2


async def test_a_shared_board_goes_to_no_site_where_its_owner_may_not_share(hub) -> None:
    admin = await hub.client("admin")
    right = {"right": "use", "site": "agv", "device": "*"}
    role = {"name": "keeper", "permissions": [right]}
    assert (await admin.post("/api/roles", json=role)).is_success
    person = {"name": "kim", "password": PASSWORD, "role": "keeper"}
    assert (await admin.post("/api/people", json=person)).is_success
    keeper = await hub.client("kim")
    at = f"/api/boards/{await made(keeper, site='agv')}"
    assert (await keeper.put(f"{at}/share", json={"share": "view"})).status_code == 204
    there = {"board": {**BOARD, "site": "yard"}, "base": 1}
    refused = await keeper.put(at, json=there)
    assert (refused.status_code, refused.json()["code"]) == (403, "forbidden")
    # While nobody else sees it, it is theirs to move; there they may not share it.
    assert (await keeper.put(f"{at}/share", json={"share": "own"})).status_code == 204
    assert (await keeper.put(at, json=there)).status_code == 200
    assert (await keeper.put(f"{at}/share", json={"share": "view"})).status_code == 403
    # Back at the site where they may, and from there to its old version of elsewhere.
    back = {"board": {**BOARD, "site": "agv"}, "base": 2}
    assert (await keeper.put(at, json=back)).status_code == 200
    assert (await keeper.put(f"{at}/share", json={"share": "view"})).status_code == 204
    restored = await keeper.post(f"{at}/versions/2/restore", json={"base": 3})
    assert restored.status_code == 403


async def test_boards_of_a_description_are_offered_and_changed_there_alone(hub) -> None:
    link = await hub.gateway()
    await link.hello(DESCRIPTION + DESCRIBED)
    operator, guest = [await hub.client(name) for name in ("operator", "guest")]
    assert await names(operator) == ["Overview", "Lobby"]
    assert await names(guest) == ["Lobby"]
    shown = (await operator.get("/api/boards/agv:overview")).json()
    assert shown["row"]["described"] is True
    (tile,) = shown["board"]["tiles"]
    assert (tile["id"], tile["settings"]) == ("t1", {"signal": "base/speed"})
    refused = await operator.put("/api/boards/agv:overview", json={"board": BOARD, "base": 1})
    assert (refused.status_code, refused.json()["code"]) == (409, "described")


async def test_a_board_goes_out_as_a_file_and_comes_back_the_same(hub) -> None:
    operator = await hub.client("operator")
    text = (await operator.post("/api/boards/text", json={"board": BOARD})).json()["text"]
    assert text.startswith("board: 1\n")
    read = (await operator.post("/api/boards/reading", json={"text": text})).json()
    assert read["board"] == BOARD
    wrong = text.replace("type: value", "type: value\n  titel: Speed")
    read = (await operator.post("/api/boards/reading", json={"text": wrong})).json()
    assert (read["board"], read["where"]) == (None, "$.tiles[0].titel")
    assert read["remedy"] == "did you mean 'title'?"


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ("name: A", "$.board"),
        ("board: 1\nname: A\ntiles: [{type: Value}]", "$.tiles[0].type"),
        ("board: 1\nname: A\ntiles: [{type: value, desktop: {x: 9, y: 0, w: 6, h: 1}}]",
         "$.tiles[0].desktop"),
        ("board: 1\nname: A\ntiles: [{type: value, settings: {signal: {a: 1}}}]",
         "$.tiles[0].settings[...]"),
        ("board: 1\nname: ''", "$.name"),
        ("board: [", "line 1, column 8"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_board_is_refused_with_the_place(text: str, where: str) -> None:
    with pytest.raises(DescriptionError) as refused:
        load_board(text)
    assert refused.value.where == where


async def test_every_database_keeps_boards_and_their_versions(database) -> None:
    clock = SystemClock()
    person = await People(database, clock).add_person("Zoë", "-", "operator")
    boards = Boards(database, clock)
    key = await boards.add_board(Board(name="Äolus ☀", site="agv"), person, "Zoë", "")
    kept = await boards.find_board(key)
    for base in (1, 2):
        assert (
            await boards.save_version(
                kept, Board(name=f"After {base}"), base=base, who="Zoë", note=""
            )
            == base + 1
        )
    assert await boards.save_version(kept, Board(name="Late"), base=1, who="", note="") is None
    assert [version.number for version in await boards.list_versions(kept)] == [3, 2, 1]
    assert (await boards.read_version(kept, 1)).name == "Äolus ☀"
    assert [board.name for board in await boards.list_boards()] == ["After 2"]
    await boards.remove_board(kept)
    assert await boards.list_boards() == []
    assert await boards.list_versions(kept) == []
