"""The folder of tiles at the start of a hub."""

from __future__ import annotations

import logging

from talaia.hub.features.extensions import tiles_of
from talaia.hub.settings import Settings


def test_a_broken_tile_is_named_in_the_log_when_the_hub_starts(tmp_path, caplog) -> None:
    (tmp_path / "tiles" / "wind").mkdir(parents=True)
    with caplog.at_level(logging.INFO):
        tiles_of(Settings(data=tmp_path / "data", extensions=tmp_path / "tiles"))
    (line,) = caplog.records
    assert line.levelno == logging.ERROR
    assert "'wind'" in line.getMessage()
    assert "it has no tile.json" in line.getMessage()


def test_the_log_says_nothing_of_tiles_that_can_be_used_or_of_no_folder(caplog, tmp_path) -> None:
    with caplog.at_level(logging.INFO):
        tiles_of(Settings(data=tmp_path))
    assert caplog.records == []
