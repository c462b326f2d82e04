"""``talaia plan``: what it prints, answers and refuses."""

from __future__ import annotations

import io
import json
import re
from pathlib import Path
from typing import Any

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


@pytest.fixture
def small_night() -> dict[str, Any]:
    night: dict[str, Any] = json.loads(NIGHT.read_bytes())
    night["requests"] = [wanted for wanted in night["requests"] if not wanted.get("arrives")][:3]
    return night


def write_night(folder: Path, text: str | dict[str, Any]) -> str:
    path = folder / "night.json"
    path.write_text(text if isinstance(text, str) else json.dumps(text))
    return str(path)


def test_an_empty_file_is_called_empty_and_a_slip_has_its_line_and_column(tmp_path):
    with pytest.raises(NotANight, match=r"night\.json: night: it is empty; "):
        main(["night", write_night(tmp_path, "\n")])
    with pytest.raises(NotANight, match=r"invalid character \(line 2, column 9\); "):
        main(["night", write_night(tmp_path, '{"site":\n {"lat":NaN}}')])


def test_what_no_night_has_is_refused_with_the_files_name_and_place(tmp_path, small_night):
    small_night["requests"][1]["windows"] = [[5000, 100]]
    with pytest.raises(
        NotANight, match=r"night\.json: request .* its window ends at 100 s, before"
    ):
        main(["night", write_night(tmp_path, small_night)])
    small_night["requests"].clear()
    small_night["proposals"].append(small_night["proposals"][0])
    with pytest.raises(NotANight, match=r"night\.json: proposals: two have the same id 'P1'; "):
        main(["night", write_night(tmp_path, small_night)])
    # Numbers that no telescope has ended in tracebacks of the arrays that plan.
    small_night["instrument"]["slew_deg_s"] = 1e-300
    with pytest.raises(NotANight, match=r">= 0\.001 - at `\$\.instrument\.slew_deg_s`"):
        main(["night", write_night(tmp_path, small_night)])


def test_a_key_with_a_slip_is_told_of_and_a_windows_editors_mark_is_not(
    tmp_path, small_night, capsys
):
    for wanted in small_night["requests"]:
        wanted["min_altitude"] = 30
    assert main(["night", write_night(tmp_path, "\ufeff" + json.dumps(small_night))]) == 0
    printed = capsys.readouterr()
    assert "requests[].min_altitude is no key of the format (3 times); passed over" in printed.err
    assert printed.err.count("\n") == 1
    assert "no plan is worth more than" in printed.out


def test_a_night_of_which_nothing_is_asked_yet_says_so(tmp_path, small_night, capsys):
    for wanted in small_night["requests"]:
        wanted["arrives"] = 60
    assert main(["night", write_night(tmp_path, small_night)]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "nothing is asked for at the start of this night: there is nothing to plan",
        "3 requests come later in the night: what is there at its start is planned",
    ]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ({"type": "decide", "t": 10**40}, "`$.t`"),
        ({"type": "interrupt", "t": 9, "request": "r0", "current": "r1"}, "no request 'r0'"),
        ("", "line: it is empty"),
    ],
    ids=["no-moment-of-a-night", "nobodys-request", "empty"],
)
def test_a_wrong_line_after_the_night_is_named_by_its_number_too(line, said, small_night):
    small_night["requests"].clear()
    del small_night["truth"]
    night = json.dumps({"type": "night", "night": small_night})
    wrong = json.dumps(line) if line else ""
    with pytest.raises(NotANight, match=f"line 2: .*{re.escape(said)}"):
        answer_lines(io.BytesIO(f"{night}\n{wrong}\n".encode()), io.BytesIO(), INDIFFERENT)
