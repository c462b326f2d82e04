"""The types of tiles that a check knows are those that the pages have."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from talaia.model.boards.tile_types import TILE_TYPES

pytestmark = pytest.mark.pure

CATALOG = Path(__file__).parents[3] / "web/src/tiles/board/board-catalog.ts"


def test_a_check_knows_the_tiles_that_the_pages_have() -> None:
    assert sorted(TILE_TYPES) == sorted(
        re.findall(r'^    type: "(\w+)"', CATALOG.read_text(), re.M)
    )
