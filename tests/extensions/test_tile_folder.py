"""The folder of tiles: what is read of it, and what is refused with which reason."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from talaia.extensions.tile_folder import read_tiles

EXAMPLES = Path(__file__).parents[2] / "examples" / "extensions" / "tiles"
GOOD = {"api": 1, "title": "A tile", "signals": {"wind": {"unit": "km/h"}}}


def add_tile(folder, name="mine", manifest=None, module=b"export default class {}"):
    tile = folder / name
    tile.mkdir(parents=True)
    (tile / "tile.json").write_text(json.dumps(GOOD if manifest is None else manifest))
    if module is not None:
        (tile / "tile.js").write_bytes(module)
    return tile


def test_the_example_is_read_with_its_files_and_their_types() -> None:
    (tile,) = read_tiles(EXAMPLES).tiles
    assert tile.name == "wind_gauge"
    assert tile.files["tile.js"].media_type.startswith("text/javascript")
    assert set(tile.files) == {"tile.js", "tile.json"}


@pytest.mark.parametrize(
    ("module", "reason"),
    [
        (None, "is not there"),
        (b"\xff\xfe\x00", "no UTF-8 text"),
        (b"<!doctype html>export", "is not JavaScript"),
        (b"let a = 1", "exports no custom element"),
    ],
)
def test_what_is_no_module_is_named_and_takes_no_other_with_it(tmp_path, module, reason) -> None:
    add_tile(tmp_path, "bad", module=module)
    add_tile(tmp_path, "good")
    found = read_tiles(tmp_path)
    assert [tile.name for tile in found.tiles] == ["good"]
    assert [tile.name for tile in found.broken] == ["bad"]
    assert reason in found.broken[0].problem


@pytest.mark.parametrize(
    ("manifest", "reason"),
    [
        ({**GOOD, "api": 2}, "version 2"),
        ({**GOOD, "hots": 1}, "hots"),
        ({**GOOD, "signals": {}}, "at least one signal"),
        ([], "tile.json"),
    ],
)
def test_a_wrong_manifest_is_named_with_the_reason(tmp_path, manifest, reason) -> None:
    add_tile(tmp_path, manifest=manifest)
    (broken,) = read_tiles(tmp_path).broken
    assert reason in broken.problem


def test_symbolic_links_are_refused(tmp_path) -> None:
    secret = tmp_path / "secret.js"
    secret.write_text("export const secret = 1")
    folder = tmp_path / "tiles"
    (add_tile(folder, "file") / "other.js").symlink_to(secret)
    shutil.copytree(EXAMPLES / "wind_gauge", tmp_path / "elsewhere")
    (folder / "whole").symlink_to(tmp_path / "elsewhere")
    found = read_tiles(folder)
    assert found.tiles == ()
    assert all("symbolic link" in tile.problem for tile in found.broken)
    assert [tile.name for tile in found.broken] == ["file", "whole"]


def test_only_what_was_found_at_the_start_can_be_asked_for(tmp_path) -> None:
    tile = add_tile(tmp_path)
    (tile / "notes.txt").write_text("not for browsers")
    found = read_tiles(tmp_path)
    (tile / "later.js").write_text("export {}")
    assert found.find_file("mine", "tile.js") is not None
    for path in ("later.js", "notes.txt", "../mine/tile.js", "/etc/passwd", "./tile.js", ""):
        assert found.find_file("mine", path) is None
