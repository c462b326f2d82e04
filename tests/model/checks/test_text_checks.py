"""Mistaken descriptions: what a beginner is told, with its line, word for word.

The table is `mistakes/mistakes.yaml`. It is checked by what `talaia check` does, without installed
extensions, so that it says the same on every machine.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
import yaml

from talaia.cli.checking.command_line import main
from talaia.model.checks.text_checks import check_text
from talaia.ros_type_library import RosTypeLibrary

if TYPE_CHECKING:
    from talaia.model.checks.text_checks import Mistake

pytestmark = pytest.mark.pure

HERE = Path(__file__).parent / "mistakes"
ROWS = yaml.safe_load((HERE / "mistakes.yaml").read_text())
# Words of Python, of its libraries and of a parser, which say nothing to a robot's maker.
FOREIGN = re.compile(
    r"\b(None|True|False|NoneType|str|int|float|bool|dict|tuple|nan|inf|token|scalar|struct|msgspec"
    r"|block mapping|node content|Traceback|object)\b|<[A-Z]\w*[.:]|use one of: *$|…\.|\.…"
)
# What somebody wrote may be any word.
WRITTEN = re.compile(r"'[^']*'|\(\.(nan|inf)\)")
# Each file of the command reads the machine's types of ROS anew: some are enough.
SOME = ROWS[::15]


@pytest.fixture(scope="module")
def types() -> RosTypeLibrary:
    return RosTypeLibrary([])


def text_of(row: dict[str, object]) -> str:
    """Give a row's text: its own, or the right description with the mistake made in it."""
    if "text" in row:
        return str(row["text"])
    text = (HERE / f"right_{row['of']}.yaml").read_text()
    changes = row["change"]
    assert isinstance(changes, dict)
    for right, wrong in changes.items():
        assert text.count(right) == 1, (row["name"], right)
        text = text.replace(right, wrong)
    return text


def told(mistakes: list[Mistake]) -> str:
    """Write mistakes as the table does, one a line."""
    return "\n".join(
        f"{one.line}:{one.column}: {one.problem}" + (f"; {one.remedy}" if one.remedy else "")
        for one in mistakes
    )


def test_there_are_a_hundred_mistakes_each_by_its_own_name() -> None:
    names = [row["name"] for row in ROWS]
    assert len(set(names)) == len(names) >= 100


@pytest.mark.parametrize("name", ["robot", "dome", "onvif", "hut"])
def test_what_the_mistakes_are_made_in_is_right(name: str, types: RosTypeLibrary) -> None:
    report = check_text((HERE / f"right_{name}.yaml").read_text(), known=types)
    assert report.mistakes == []
    assert report.notes == []


@pytest.mark.parametrize("row", ROWS, ids=[row["name"] for row in ROWS])
def test_each_mistake_is_told_with_its_place_and_what_to_do(
    row: dict[str, object], types: RosTypeLibrary
) -> None:
    mistakes = check_text(text_of(row), known=types).mistakes
    assert told(mistakes) == row["told"]
    for one in mistakes:
        assert one.line > 0, one
        said = WRITTEN.sub("", f"{one.problem}; {one.remedy}")
        assert FOREIGN.search(said) is None, one


def test_the_command_prints_the_same_places_for_people_and_for_editors(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    paths = []
    for number, row in enumerate(SOME):
        path = tmp_path / f"{number:03}.yaml"
        path.write_text(text_of(row))
        paths.append(str(path))
    assert main(["--json", *paths]) == 1
    rows = json.loads(capsys.readouterr().out)
    assert main(paths) == 1
    printed = capsys.readouterr().err
    for number, row in enumerate(SOME):
        of_file = [one for one in rows if one["file"] == paths[number] and one["level"] == "error"]
        places = [f"{one['line']}:{one['column']}" for one in of_file]
        assert places == [line.split(": ")[0] for line in str(row["told"]).splitlines()]
        for place in places:
            assert f"--> {paths[number]}:{place}\n" in printed


def test_what_a_board_shows_that_this_site_has_not_is_noted_and_no_mistake(
    types: RosTypeLibrary,
) -> None:
    # Chosen above it, another site may have it; by its device and by its role nobody can tell.
    board = (
        "boards:\n  main:\n    name: Main\n    tiles:\n"
        "      - {type: chart, settings: {signals: [base/speed, base/sped, $device/x, '@y']}}\n"
    )
    text = text_of({"of": "robot", "change": {"devices:\n": f"{board}devices:\n"}})
    report = check_text(text, known=types)
    assert report.mistakes == []
    assert told(report.notes) == "12:56: unknown signal 'base/sped'; did you mean 'base/speed'?"


@pytest.mark.parametrize("opening", ["[", "{a: ", "- ", "? "])
def test_what_is_nested_without_an_end_ends_nobody(opening: str) -> None:
    """Where it did, it was the whole process: libyaml calls itself for each."""
    (one,) = check_text("a: " * (opening in "[{a: ") + opening * 100_000).mistakes
    assert (one.line, one.problem) == (1, "nested deeper than 64")
