"""What ``talaia extensions`` lists of a folder of tiles."""

from __future__ import annotations

from pathlib import Path

from talaia.cli.extensions import main

EXAMPLES = Path(__file__).parents[2] / "examples" / "extensions" / "tiles"


def test_each_tile_is_listed_with_whether_it_can_be_used(tmp_path, capsys) -> None:
    (tmp_path / "broken").mkdir()
    (tmp_path / "wind_gauge").mkdir()
    for file in (EXAMPLES / "wind_gauge").iterdir():
        (tmp_path / "wind_gauge" / file.name).write_bytes(file.read_bytes())
    assert main(["--extensions", str(tmp_path)]) == 1
    said = capsys.readouterr()
    assert "tile wind_gauge: " in said.out
    assert "(can be used)" in said.out
    assert "tile broken: broken: it has no tile.json" in said.err


def test_a_folder_in_which_all_can_be_used_is_no_failure(capsys) -> None:
    assert main(["--extensions", str(EXAMPLES)]) == 0
    assert "tile wind_gauge" in capsys.readouterr().out


def test_a_folder_that_is_not_there_is_named(tmp_path, capsys) -> None:
    assert main(["--extensions", str(tmp_path / "none")]) == 2
    assert "cannot be read" in capsys.readouterr().err
