"""``talaia upgrade`` on files: it shows first, and writes whole files only."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from talaia.cli.main import main

pytestmark = pytest.mark.pure

EXAMPLE = Path(__file__).parents[2] / "examples/agv/site.yaml"
OLD = """\
talaia: 1
site: cart
name: Cart
ros2: {}
devices:
  base:
    name: Base
    # it coasts
    drive: {topic: /cmd_vel, max_speed: 1, max_turn: 1, link_loss: nothing}
"""


@pytest.fixture
def old(tmp_path: Path) -> Path:
    path = tmp_path / "site.yaml"
    path.write_text(OLD)
    path.chmod(0o640)
    return path


def test_what_would_change_is_shown_and_nothing_is_changed(
    old: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["upgrade", str(old)]) == 1
    said = capsys.readouterr()
    changed = [line for line in said.out.splitlines() if line[:1] in "+-"][2:]
    assert [line[0] for line in changed] == ["-", "+"]
    assert "link_loss: hold" in changed[1]
    assert "--write" in said.err
    assert old.read_text() == OLD


def test_with_write_the_file_is_changed_and_stays_as_readable_as_it_was(
    old: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    link = old.with_name("link.yaml")
    link.symlink_to(old)
    assert main(["upgrade", "--write", str(link)]) == 0
    assert old.read_text() == OLD.replace("nothing", "hold")
    assert link.is_symlink()
    assert stat.S_IMODE(old.stat().st_mode) == 0o640
    assert sorted(os.listdir(old.parent)) == ["link.yaml", "site.yaml"]
    capsys.readouterr()
    assert main(["upgrade", str(old)]) == 0
    assert "newest format already" in capsys.readouterr().err


def test_of_several_files_each_is_told_and_one_that_is_too_new_stops_none(
    old: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    newer = old.with_name("newer.yaml")
    newer.write_text("talaia: 9\n")
    assert main(["upgrade", "--write", str(newer), str(old), str(EXAMPLE)]) == 1
    said = capsys.readouterr().err
    assert f"{newer}: $.talaia: the description is of format version 9" in said
    assert "newer Talaia" in said
    assert old.read_text() == OLD.replace("nothing", "hold")
    assert newer.read_text() == "talaia: 9\n"


def test_mistakes_that_were_there_are_told(old: Path, capsys: pytest.CaptureFixture[str]) -> None:
    old.write_text(OLD.replace("max_turn: 1", "max_turn: -1"))
    assert main(["upgrade", "--write", str(old)]) == 1
    assert "max_turn" in capsys.readouterr().err
    assert "link_loss: hold" in old.read_text()


def test_a_file_that_is_not_there_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "no.yaml"
    assert main(["upgrade", str(file)]) == 1
    assert capsys.readouterr().err.startswith(f"{file}: there is no such file; look at its name")
