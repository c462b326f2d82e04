"""Rows of the journal are read back with their channels' numbers, less what is elsewhere."""

from __future__ import annotations

import numpy as np
import pytest

from talaia.hub.history.blocks.journal import read_rows, write_row
from talaia.hub.history.writing.channel_ids import Catalogue
from talaia.hub.history.writing.journal_replay import JournalReader

from ..samples import batch

pytestmark = pytest.mark.pure

CATALOGUES = {2: Catalogue(2, np.array([10, 11])), 7: Catalogue(7, np.array([11, 12, 13]))}
ROWS = [
    [(0, 100, 1.0), (1, 101, 2.0)],
    [(2, 102, "on"), (0, 103, 3.0)],
    [(1, 104, "off")],
]


def read_chunk(saved_row):
    """Read `ROWS`, of which the first and the last have the first list."""
    reader = JournalReader(CATALOGUES, saved_row)
    read = read_rows([write_row(batch(rows)) for rows in ROWS])
    return reader.read_chunk(np.array([5, 6, 9]), np.array([2, 7, 2]), read)


def test_each_row_is_read_by_its_own_list_of_channels() -> None:
    chunk = read_chunk({})
    assert chunk.row == 5
    assert chunk.channel.tolist() == [10, 11, 13, 11, 11]
    assert chunk.time_us.tolist() == [100, 101, 102, 103, 104]
    assert chunk.texts == {2: "on", 4: "off"}


def test_what_a_block_or_a_saved_tail_has_is_left_out() -> None:
    chunk = read_chunk({10: 4, 11: 6, 13: 9})
    assert chunk.channel.tolist() == [10, 11]
    assert chunk.time_us.tolist() == [100, 104]
    assert chunk.texts == {1: "off"}


def test_a_channel_that_is_in_no_list_is_told_and_not_taken_for_another() -> None:
    reader = JournalReader(CATALOGUES, {})
    read = read_rows([write_row(batch([(2, 100, 1.0)]))])
    for unknown in (2, 3):
        with pytest.raises(IndexError, match="channel"):
            reader.read_chunk(np.array([1]), np.array([unknown]), read)
