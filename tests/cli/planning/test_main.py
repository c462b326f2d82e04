"""``talaia plan``: what it prints, answers and refuses."""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest

from talaia.cli.planning.command_line import main
from talaia.cli.planning.main import answer_lines
from talaia.planner.errors import NotANight
from talaia.planner.fairness import INDIFFERENT

pytestmark = pytest.mark.pure

NIGHT = Path(__file__).parents[3] / "bench" / "nights" / "hundred.json"


def test_a_night_is_printed_with_reasons_and_its_bound(capsys):
    assert main(["night", str(NIGHT)]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert "a minute" in printed[0]
    assert sum("no plan is worth more than" in line for line in printed) == 1
    assert sum(line.startswith("not now: ") for line in printed) == 10


def test_lines_are_answered_one_by_one_and_nothing_else_is_written():
    night = json.loads(NIGHT.read_bytes())
    del night["truth"]
    night["requests"] = [wanted for wanted in night["requests"] if not wanted.get("arrives")]
    lines = [
        {"type": "night", "night": night},
        {"type": "decide", "t": 20_000, "events": [], "completed": []},
    ]
    answers = io.BytesIO()
    said = b"".join(json.dumps(line).encode() + b"\n" for line in lines)
    assert answer_lines(io.BytesIO(said), answers, INDIFFERENT) == 0
    first, second = (json.loads(line) for line in answers.getvalue().splitlines())
    assert first == {}
    assert second["observe"] in {wanted["id"] for wanted in night["requests"]}
    assert second["not_before"] >= 20_046
    assert "worth" in second["reason"]


def test_a_wrong_line_is_named_by_its_number():
    with pytest.raises(NotANight, match="line 1: "):
        answer_lines(io.BytesIO(b"nonsense\n"), io.BytesIO(), INDIFFERENT)


def test_a_file_that_is_not_there_is_an_error_in_words(tmp_path):
    with pytest.raises(NotANight, match=r"none\.json: cannot be read: No such file or directory$"):
        main(["night", str(tmp_path / "none.json")])


def test_a_file_that_is_no_night_is_named_with_what_is_missing_in_it(tmp_path):
    (tmp_path / "no.json").write_text("{}")
    with pytest.raises(NotANight, match=r"no\.json: night: .*missing required field `site`"):
        main(["night", str(tmp_path / "no.json")])
