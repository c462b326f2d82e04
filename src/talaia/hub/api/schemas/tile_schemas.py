"""What the routes of tiles and boards take and give."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, Field

from talaia.extensions.tile_folder import BrokenTile  # noqa: TC001 - pydantic reads it
from talaia.hub.api.schemas.common import Schema
from talaia.hub.auth.board_access import BoardShare  # noqa: TC001 - pydantic reads it
from talaia.model.closed_lists import DeviceKind, SignalType  # noqa: TC001 - pydantic reads them
from talaia.model.roles import SignalRole  # noqa: TC001 - pydantic reads it

__all__ = [
    "BoardAsk",
    "BoardChangeAsk",
    "BoardDetail",
    "BoardList",
    "BoardPlaceShape",
    "BoardReading",
    "BoardRestoreAsk",
    "BoardRow",
    "BoardSaved",
    "BoardShape",
    "BoardShareAsk",
    "BoardText",
    "BoardTileShape",
    "BoardVersionList",
    "BoardVersionShape",
    "TileList",
    "TileShape",
    "TileSignalShape",
]


class TileSignalShape(BaseModel):
    """Which signal of a device a tile reads; what is empty fits any."""

    name: str = Field(description="the tile's own name for it")
    type: SignalType | Literal[""]
    unit: str
    id: str
    role: SignalRole | Literal[""]


class TileShape(BaseModel):
    """A web component that a device's page shows where the device has all its signals."""

    name: str = Field(description="of its folder")
    title: str
    module: str = Field(description="path of the JavaScript module at this hub")
    device: DeviceKind | Literal[""] = Field(
        description="the kind of device that it is for; empty: every kind"
    )
    signals: list[TileSignalShape]


class TileList(BaseModel):
    """The tiles in the hub's folder of extensions."""

    api: int = Field(description="version of the interface for tiles")
    tiles: list[TileShape]
    broken: list[BrokenTile] = Field(description="for who may manage the whole hub")


class BoardPlaceShape(Schema):
    """Where a tile stands on a grid, in whole columns and rows."""

    x: int = Field(ge=0, le=100)
    y: int = Field(ge=0, le=10_000)
    w: int = Field(ge=1, le=100)
    h: int = Field(ge=1, le=100)


class BoardTileShape(Schema):
    """A tile of a board.

    ``type`` is of the pages' catalogue; a place that is null is given by the page.
    """

    id: str = Field(max_length=32)
    type: str = Field(max_length=32)
    title: str = Field(max_length=200)
    settings: dict[str, bool | int | float | str | list[str]]
    desktop: BoardPlaceShape | None
    phone: BoardPlaceShape | None


class BoardShape(Schema):
    """A board: tiles on a grid of 12 columns, and of 4 on a phone.

    ``site``, ``device``: which it shows until others are chosen; ``kind``: of the device.
    """

    name: str = Field(min_length=1, max_length=100)
    note: str = Field(max_length=4000)
    site: str = Field(max_length=63)
    kind: DeviceKind | Literal[""]
    device: str = Field(max_length=63)
    tiles: list[BoardTileShape] = Field(max_length=100)


class BoardRow(Schema):
    """A board in the list.

    ``described``: it is of its site's description, and changed there. ``share``: who sees it
    beside its owner: ``role`` those of ``role``, ``view`` who sees the site, ``public`` everybody.
    ``number``: of its newest version. ``may_change``, ``may_share``: you may.
    """

    key: str
    name: str
    site: str
    kind: str
    described: bool
    owner: str
    share: BoardShare
    role: str
    number: int
    tiles: int
    changed_us: int
    may_change: bool
    may_share: bool


class BoardList(Schema):
    """The boards that are open to you."""

    boards: list[BoardRow]


class BoardDetail(Schema):
    """A board, and what the list says of it; ``number`` is that of the version."""

    row: BoardRow
    number: int
    board: BoardShape


class BoardAsk(Schema):
    """Keep a board; ``note`` says in a few words what was done."""

    board: BoardShape
    note: str = Field(default="", max_length=200)


class BoardChangeAsk(BoardAsk):
    """Keep another version; ``base`` is the newest one that you know."""

    base: int = Field(ge=1, le=2**31 - 1)


class BoardRestoreAsk(Schema):
    """Go back to a version; ``base`` is the newest one that you know."""

    base: int = Field(ge=1, le=2**31 - 1)


class BoardSaved(Schema):
    """Where a board is kept, and the number of its newest version."""

    key: str
    number: int


class BoardShareAsk(Schema):
    """Who is to see a board beside its owner; ``role`` names one, for ``role``."""

    share: Literal[BoardShare.OWN, BoardShare.ROLE, BoardShare.VIEW]
    role: str = Field(default="", max_length=200)


class BoardVersionShape(Schema):
    """A version of a board."""

    number: int
    time_us: int
    who: str
    note: str


class BoardVersionList(Schema):
    """A board's versions, the newest first."""

    versions: list[BoardVersionShape]


class BoardText(Schema):
    """A board as the text of a file (YAML)."""

    text: str = Field(max_length=262_144)


class BoardReading(Schema):
    """What a file says: a board, or what is wrong with it and where."""

    board: BoardShape | None
    where: str
    problem: str
    remedy: str
