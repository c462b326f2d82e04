"""A board as a YAML file of its own, to and fro."""

from __future__ import annotations

import re

import msgspec

from talaia.model.boards.board import Board, BoardTile, TilePlace
from talaia.model.boards.board_checks import board_findings
from talaia.model.errors import DescriptionError, NotReadable, UnknownWord
from talaia.model.yaml_text.document import dump_document, read_document

__all__ = ["BOARD_FORMAT", "dump_board", "load_board", "read_board_json", "write_board_json"]

BOARD_FORMAT = 1
MAX_BYTES = 256 * 1024
# msgspec learns a type when it first converts to it; imports are done by one thread.
_decoder = msgspec.json.Decoder(Board)
_AT = re.compile(r"^(?P<problem>.*?)(?: - at `(?P<path>.*)`)?$", re.DOTALL)
_UNKNOWN_FIELD = re.compile(r"unknown field `(.*)`")


def load_board(text: str) -> Board:
    """Make a board of the text of a file.

    Raises:
        DescriptionError: with the place of the mistake (``$.tiles[2].desktop``), what was
            expected and what was found.

    """
    if len(text.encode()) > MAX_BYTES:
        raise NotReadable("$", f"the board is longer than {MAX_BYTES // 1024} KiB")
    document = read_document(text)
    if not isinstance(document, dict) or document.get("board") != BOARD_FORMAT:
        problem = "this is not the file of a board"
        raise DescriptionError("$.board", problem, f"it begins with: board: {BOARD_FORMAT}")
    board = convert_board({key: value for key, value in document.items() if key != "board"})
    for finding in board_findings("$", board):
        raise DescriptionError(*finding)
    return board


def convert_board(document: object) -> Board:
    """Make a board of plain values.

    Raises:
        DescriptionError: they have not the shape of one.

    """
    try:
        return msgspec.convert(document, Board)
    except msgspec.ValidationError as error:
        match = _AT.match(str(error))
        problem, path = (match["problem"], match["path"] or "$") if match else (str(error), "$")
        unknown = _UNKNOWN_FIELD.search(problem)
        if unknown:
            known = _keys_at(path)
            raise UnknownWord(f"{path}.{unknown[1]}", "key", unknown[1], known) from error
        said = problem[:1].lower() + problem[1:].replace("`", "")
        raise DescriptionError(path, said) from error


def _keys_at(path: str) -> tuple[str, ...]:
    if path.endswith((".desktop", ".phone")):
        return TilePlace.__struct_fields__
    return BoardTile.__struct_fields__ if path.endswith("]") else Board.__struct_fields__


def dump_board(board: Board) -> str:
    """Write a board as the text of a file that `load_board` reads back to an equal one."""
    plain = {"board": BOARD_FORMAT, **msgspec.to_builtins(board)}
    return dump_document(plain)


def read_board_json(text: str) -> Board:
    """Read a board as the database holds it."""
    return _decoder.decode(text)


def write_board_json(board: Board) -> str:
    """Write a board for the database."""
    return msgspec.json.encode(board).decode()
