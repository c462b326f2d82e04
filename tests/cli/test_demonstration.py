"""A demo in a folder of an earlier run: the examples are as new, and what people made is theirs."""

from __future__ import annotations

from pathlib import Path

import pytest

from talaia.cli.demo.session import Login, is_changed, print_greeting, write_description


def test_what_the_demo_wrote_itself_is_no_change(tmp_path: Path) -> None:
    path = tmp_path / "agv.yaml"
    assert not is_changed(path)
    write_description(path, "name: Example\n")
    assert not is_changed(path)
    assert path.read_text() == "name: Example\n"


def test_what_somebody_changed_stays_theirs_until_it_is_removed(tmp_path: Path) -> None:
    path = tmp_path / "agv.yaml"
    write_description(path, "name: Example\n")
    path.write_text("name: Ours\n")
    assert is_changed(path)
    path.unlink()
    assert not is_changed(path)


def test_a_description_of_a_demo_that_noted_nothing_counts_as_somebodys_work(
    tmp_path: Path,
) -> None:
    path = tmp_path / "agv.yaml"
    path.write_text("name: Of long ago\n")
    assert is_changed(path)


def test_the_greeting_says_which_description_is_not_the_example_and_how_to_get_it_back(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "our demo"
    people = [Login("admin", "word", "admin")]
    print_greeting(
        "http://localhost:1", people, data=folder, took=1.0, changed=[folder / "agv.yaml"]
    )
    said = capsys.readouterr().out
    assert "agv.yaml was changed in an earlier run and stays so;" in said
    assert f"run: rm '{folder}/agv.yaml'" in said
    print_greeting(
        "http://localhost:1", people, data=folder, took=1.0, notes=["nothing can be seen here"]
    )
    said = capsys.readouterr().out
    assert "was changed" not in said
    assert "\n  nothing can be seen here\n" in said
