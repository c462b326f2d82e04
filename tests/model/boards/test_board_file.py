"""Boards as files: whatever a person wrote comes back as it was."""

from __future__ import annotations

import pytest

from talaia.model.boards.board import Board
from talaia.model.boards.board_file import dump_board, load_board

pytestmark = pytest.mark.pure


@pytest.mark.parametrize("text", ["1e9", "-2.5E-3", "1:30", "010", "yes", "null", "a: b # c", "é"])
def test_a_text_that_looks_like_something_else_comes_back_as_a_text(text: str) -> None:
    board = Board(name=text, note=text)
    assert load_board(dump_board(board)) == board
