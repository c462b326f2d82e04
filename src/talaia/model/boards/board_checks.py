"""What does not fit together in a board; of descriptions a part of `check_site`."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from talaia.model.boards.board import DESKTOP_COLUMNS, PHONE_COLUMNS
from talaia.model.boards.tile_types import TILE_TYPES
from talaia.model.checks.identifiers import Finding, finding_of, id_fits, name_fits
from talaia.model.errors import UnknownWord

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.boards.board import Board, BoardTile, TilePlace, TileSetting
    from talaia.model.site import Site

__all__ = ["board_findings", "board_notes", "boards_findings", "tile_type_findings"]

# Each tile asks the hub for what it shows.
MOST_TILES = 100
_MOST_BOARDS = 50
_MOST_SETTINGS = 40
_MOST_WORDS = 64
_LONGEST_TEXT = 4000
_MOST_ROWS = 40
_LOWEST = 2000
# Settings of the pages' tiles that are addresses, and of what.
_ADDRESSES = {
    **dict.fromkeys(("signal", "signals", "x", "y", "colour"), "signal"),
    **dict.fromkeys(("stream", "streams"), "camera"),
    "command": "command",
}
_TYPE = re.compile(r"[a-z][a-z0-9_]{0,31}\Z")
_ID = re.compile(r"[a-z0-9][a-z0-9_-]{0,31}\Z")


def boards_findings(site: Site) -> Iterator[Finding]:
    """List what does not fit in a description's boards."""
    if len(site.boards) > _MOST_BOARDS:
        yield Finding("$.boards", f"more than {_MOST_BOARDS} boards")
    for name, board in site.boards.items():
        where = f"$.boards.{name}"
        yield from id_fits(where, name)
        yield from board_findings(where, board)
        if board.site not in ("", site.site):
            problem = f"a board of this description is for {site.site!r}, not {board.site!r}"
            yield Finding(f"{where}.site", problem, "leave the key out")
        if board.device and board.device not in site.devices:
            problem = f"there is no device {board.device!r}"
            yield Finding(f"{where}.device", problem, "name a device of the description")


def tile_type_findings(site: Site) -> Iterator[Finding]:
    """List tiles whose type no page knows."""
    for where, tile in _tiles_of(site):
        # What can be no type at all has its own finding.
        if tile.type not in TILE_TYPES and _TYPE.match(tile.type):
            yield finding_of(UnknownWord(f"{where}.type", "tile", tile.type, TILE_TYPES))


def board_notes(site: Site) -> Iterator[Finding]:
    """Name what tiles show and this site has not: another site, chosen above them, may have it."""
    known: dict[str, list[str]] = {"signal": [], "camera": [], "command": []}
    for device_id, device in site.devices.items():
        known["signal"] += [f"{device_id}/{signal_id}" for signal_id in device.signals]
        known["camera"] += [f"{device_id}/{stream_id}" for stream_id in device.streams]
        known["command"] += [f"{device_id}/{command_id}" for command_id in device.commands]
    for at, tile in _tiles_of(site):
        for where, what, word in _addresses_in(at, tile):
            if word not in known[what]:
                yield finding_of(UnknownWord(where, what, word, known[what]))


def _tiles_of(site: Site) -> Iterator[tuple[str, BoardTile]]:
    for name, board in site.boards.items():
        for index, tile in enumerate(board.tiles):
            yield f"$.boards.{name}.tiles[{index}]", tile


def _addresses_in(at: str, tile: BoardTile) -> Iterator[tuple[str, str, str]]:
    """Give each address in a tile's settings: where it stands, of what it is, and itself."""
    for key, setting in tile.settings.items():
        what = _ADDRESSES.get(key)
        if what is None:
            continue
        where = f"{at}.settings.{key}"
        words = (
            [(f"{where}[{place}]", word) for place, word in enumerate(setting)]
            if isinstance(setting, tuple)
            else [(where, setting)]
        )
        for place_of_word, word in words:
            # By the board's device, or by its role: that is found where it is shown.
            if isinstance(word, str) and word[:1] not in ("$", "@", ""):
                yield place_of_word, what, word


def board_findings(where: str, board: Board) -> Iterator[Finding]:
    """List what does not fit in one board that stands at ``where``."""
    yield from name_fits(f"{where}.name", board.name)
    for key, word in (("site", board.site), ("device", board.device)):
        if word:
            yield from id_fits(f"{where}.{key}", word)
    yield from _text_fits(f"{where}.note", board.note)
    if len(board.tiles) > MOST_TILES:
        yield Finding(f"{where}.tiles", f"more than {MOST_TILES} tiles", "make a second board")
    seen: set[str] = set()
    for index, tile in enumerate(board.tiles):
        at = f"{where}.tiles[{index}]"
        yield from _tile_findings(at, tile)
        if tile.id and tile.id in seen:
            yield Finding(f"{at}.id", f"two tiles are called {tile.id!r}", "name one otherwise")
        seen.add(tile.id)


def _tile_findings(at: str, tile: BoardTile) -> Iterator[Finding]:
    if not _TYPE.match(tile.type):
        problem = f"{tile.type!r} cannot be a type of tile"
        yield Finding(f"{at}.type", problem, "write for example: type: value")
    if tile.id and not _ID.match(tile.id):
        remedy = "use small letters, digits, _ and - (at most 32)"
        yield Finding(f"{at}.id", f"{tile.id!r} cannot name a tile", remedy)
    yield from _text_fits(f"{at}.title", tile.title, 200)
    yield from _place_fits(f"{at}.desktop", tile.desktop, DESKTOP_COLUMNS)
    yield from _place_fits(f"{at}.phone", tile.phone, PHONE_COLUMNS)
    if len(tile.settings) > _MOST_SETTINGS:
        yield Finding(f"{at}.settings", f"more than {_MOST_SETTINGS} settings")
    for key, setting in tile.settings.items():
        yield from _setting_fits(f"{at}.settings.{key}", key, setting)


def _setting_fits(where: str, key: str, setting: TileSetting) -> Iterator[Finding]:
    yield from id_fits(where, key)
    words = setting if isinstance(setting, tuple) else ()
    if len(words) > _MOST_WORDS:
        yield Finding(where, f"more than {_MOST_WORDS} of one setting")
    for word in (*words, setting) if isinstance(setting, str) else words:
        yield from _text_fits(where, word)


def _text_fits(where: str, text: str, longest: int = _LONGEST_TEXT) -> Iterator[Finding]:
    if len(text) > longest:
        yield Finding(where, f"longer than {longest} characters")
    if "\0" in text:
        yield Finding(where, "holds the character NUL")


def _place_fits(where: str, place: TilePlace | None, columns: int) -> Iterator[Finding]:
    if place is None:
        return
    if place.x < 0 or place.w < 1 or place.x + place.w > columns:
        problem = f"columns {place.x} to {place.x + place.w} of a grid of {columns}"
        yield Finding(where, problem, f"x is 0 or more, w 1 or more, together {columns} at most")
    if not (0 <= place.y <= _LOWEST and 1 <= place.h <= _MOST_ROWS):
        problem = f"row {place.y}, {place.h} rows high"
        yield Finding(where, problem, f"y is 0 to {_LOWEST}, h is 1 to {_MOST_ROWS}")
