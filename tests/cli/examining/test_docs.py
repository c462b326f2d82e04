"""`talaia docs`: each guide that a message names is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from talaia.cli.examining.docs import main, read_guides

pytestmark = pytest.mark.pure

SOURCE = Path(__file__).parents[3] / "src/talaia"


def test_each_guide_that_a_message_names_is_there() -> None:
    texts = [path.read_text(encoding="utf-8") for path in SOURCE.rglob("*.py")]
    named = {
        name for text in texts for name in re.findall(r"talaia docs ([a-z][a-z/-]*[a-z])", text)
    }
    named |= {name for text in texts for name in re.findall(r'guide="([a-z-]+)"', text)}
    assert {"interlocks", "mqtt", "openid-connect", "scale"} <= named
    assert named <= read_guides().keys()


def test_no_message_sends_people_to_files_of_the_project() -> None:
    told = [
        f"{path.name}: {line.strip()}"
        for path in SOURCE.rglob("*.py")
        for line in path.read_text(encoding="utf-8").splitlines()
        if re.search(r"[\"'].*docs/how-to/", line)
    ]
    assert told == []


def test_a_guide_is_printed_and_all_are_listed_by_their_titles(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["interlocks"]) == 0
    assert capsys.readouterr().out.startswith("# Make a robot safe by itself")
    assert main([]) == 0
    listed = capsys.readouterr().out.splitlines()
    assert any(re.match(r"extend/adapters? +\S", line) for line in listed)
    assert any(re.match(r"interlocks +Make a robot safe by itself", line) for line in listed)


def test_a_guide_by_another_name_is_told_which_was_meant(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["interlock"]) == 2
    assert capsys.readouterr().err == (
        "talaia docs: there is no guide 'interlock'; did you mean interlocks?\n"
    )
