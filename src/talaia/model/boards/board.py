"""A board as a value: tiles on two grids, one for a desktop and one for a phone.

The same shape stands in a site description (``boards:``), in a file of its own, and in the hub's
database. What a tile shows and by which settings is the pages' catalogue of tiles: here a tile has
a type and plain settings, so that a new tile takes no change of the model.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TypeAlias

from talaia.model.base import Shape
from talaia.model.closed_lists import DeviceKind  # noqa: TC001 - msgspec reads it

__all__ = [
    "DESKTOP_COLUMNS",
    "PHONE_COLUMNS",
    "Board",
    "BoardOpenness",
    "BoardTile",
    "TilePlace",
    "TileSetting",
]

DESKTOP_COLUMNS = 12
PHONE_COLUMNS = 4

TileSetting: TypeAlias = bool | int | float | str | tuple[str, ...]


class BoardOpenness(StrEnum):
    """Who sees a board of a description. It opens no data: each tile asks for its own rights."""

    VIEW = "view"
    PUBLIC = "public"


class TilePlace(Shape, frozen=True, kw_only=True):
    """Where a tile stands on a grid, in whole columns and rows.

    Attributes:
        x: columns to its left.
        y: rows above it.
        w: columns that it takes.
        h: rows that it takes.

    """

    x: int
    y: int
    w: int
    h: int


class BoardTile(Shape, frozen=True, kw_only=True):
    """One tile.

    Attributes:
        type: what it shows, by the name of the pages' catalogue: ``value``, ``chart``, ``camera``.
        id: tells it from the other tiles of its board; it gets one where it is left out.
        title: stands above it; what it shows gives the title where this is left out.
        settings: by key. A signal is named ``<device>/<signal>``, ``$device/<signal>`` for the
            board's device, or by its role: ``@weather.wind``.
        desktop: its place on the grid of 12 columns; it is given one where this is left out.
        phone: its place on the grid of 4 columns; it is given one where this is left out.

    """

    type: str
    id: str = ""
    title: str = ""
    settings: dict[str, TileSetting] = {}
    desktop: TilePlace | None = None
    phone: TilePlace | None = None


class Board(Shape, frozen=True, kw_only=True):
    """A board.

    Attributes:
        name: what people call it.
        note: what it is for, in a sentence.
        site: the site that it is for; any that is chosen above it where this is left out.
        kind: the kind of device that it is for; the device is then chosen above it.
        device: the device that ``$device`` is until another is chosen.
        share: of a description's board: who sees it.
        tiles: what stands on it.

    """

    name: str
    note: str = ""
    site: str = ""
    kind: DeviceKind | None = None
    device: str = ""
    share: BoardOpenness = BoardOpenness.VIEW
    tiles: tuple[BoardTile, ...] = ()
