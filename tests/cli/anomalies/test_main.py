"""``talaia anomalies backtest``: what it prints of a table, and what it says of bad ones."""

from __future__ import annotations

import csv
import io
import random
from typing import TYPE_CHECKING

import pytest

from talaia.cli.anomalies.command_line import DETECTOR_NAMES, main
from talaia.cli.anomalies.judges import DETECTORS
from talaia.cli.errors import BadRows, CliError
from talaia.hub.anomaly.kinds import KINDS

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

pytestmark = pytest.mark.pure

HEADING = "datetime;flow;heat, motor;anomaly;changepoint"


def pump_lines(count: int = 200, fault: int = 150) -> list[str]:
    """Make a table whose flow falls at row ``fault``, from 0."""
    chance = random.Random(1)  # noqa: S311 - noise
    lines = [HEADING]
    for at in range(count):
        flow = (30 if at < fault else 20) + chance.gauss(0, 0.5)
        heat = 60 + chance.gauss(0, 0.5)
        lines.append(f"2020-03-09 10:{at // 60:02}:{at % 60:02};{flow:.3f};{heat:.3f};0.0;0.0")
    return lines


def write_table(folder: Path, lines: Sequence[str]) -> str:
    path = folder / "pump.csv"
    path.write_text("\n".join(lines) + "\n")
    return str(path)


def backtest(path: str, *more: str) -> int:
    return main(["backtest", path, "--learn-rows", "100", *more])


def test_the_words_of_the_command_know_every_detector():
    assert DETECTOR_NAMES == DETECTORS


def test_each_row_has_its_line_with_score_and_the_signals_that_made_it_so(tmp_path, capsys):
    path = write_table(tmp_path, pump_lines())
    assert backtest(path, "--detector", "group", "--rows") == 0
    printed = capsys.readouterr()
    rows = list(csv.DictReader(io.StringIO(printed.out)))
    assert printed.out.splitlines()[0] == "time,score,anomalous,signals"
    assert [row["time"] for row in rows][:2] == ["2020-03-09 10:00:00", "2020-03-09 10:00:01"]
    assert len(rows) == 200
    assert {row["anomalous"] for row in rows[:150]} == {"0"}
    assert {row["signals"] for row in rows[:150]} == {""}
    assert rows[-1]["anomalous"] == "1"
    assert rows[-1]["signals"].startswith("flow ")
    assert rows[-1]["signals"].endswith(" %")
    assert float(rows[-1]["score"]) > 0.5
    assert printed.err == "not looked at: anomaly, changepoint\n"


def test_without_rows_each_anomaly_has_its_line(tmp_path, capsys):
    assert backtest(write_table(tmp_path, pump_lines())) == 0
    (anomaly,) = csv.DictReader(io.StringIO(capsys.readouterr().out))
    assert "2020-03-09 10:02:30" <= anomaly["began"] <= "2020-03-09 10:02:40"
    assert anomaly["ended"] == "2020-03-09 10:03:19"
    assert anomaly["signals"].startswith("flow ")


@pytest.mark.parametrize("name", [name for name in DETECTORS if name != "group"])
def test_detectors_of_one_signal_judge_each_column(tmp_path, capsys, name):
    path = write_table(tmp_path, pump_lines())
    assert backtest(path, "--detector", name, "--rows") == 0
    rows = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    assert len(rows) == 200
    assert {row["anomalous"] for row in rows[:100]} == {"0"}
    if name in ("baseline", "iqr"):
        assert rows[150]["anomalous"] == "1"
        assert rows[150]["signals"].startswith("flow 0.")


@pytest.mark.parametrize("name", ["group", "iqr", "rate"])
def test_missing_values_and_rows_that_are_not_newer_are_borne_and_counted(tmp_path, capsys, name):
    lines = pump_lines()
    lines[20] = lines[20].replace(lines[20].split(";")[1], "")
    lines[21] = lines[21].replace(lines[21].split(";")[2], "nan")
    lines[22] = lines[22].replace(lines[22].split(";")[2], "inf")
    lines[101] = lines[101].replace(lines[101].split(";")[2], "-inf")
    lines.insert(120, lines[119])
    lines.insert(50, "")
    assert backtest(write_table(tmp_path, lines), "--detector", name, "--rows") == 0
    printed = capsys.readouterr()
    rows = list(csv.DictReader(io.StringIO(printed.out)))
    assert len(rows) == 201
    assert all(0.0 <= float(row["score"]) <= 1.0 for row in rows)
    assert rows[100]["anomalous"] == rows[99]["anomalous"] == "0"
    assert "1 rows are not newer than the row before them and were not looked at" in printed.err


def test_columns_are_chosen_or_left_out_by_their_headings(tmp_path, capsys):
    path = write_table(tmp_path, pump_lines())
    assert backtest(path, "--signals", "heat, motor") == 0
    assert capsys.readouterr().out == "began,ended,rows,score,signals\n"
    assert backtest(path, "--ignore", "flow") == 0
    assert capsys.readouterr().err == "not looked at: flow, anomaly, changepoint\n"


def broken(line: int, text: str) -> list[str]:
    lines = pump_lines()
    lines[line - 1] = text
    return lines


BAD = {
    "no times": ([HEADING.replace("datetime", "when")], "line 1: expected a heading with a column"),
    "no signals": (["time", "2020-01-01"], "line 1: expected a column for each signal"),
    "empty": ([], "line 1: expected a heading with a column of times"),
    "word": (
        broken(30, "2020-03-09 10:00:28;idle;60;0;0"),
        "line 30, column 'flow': expected a number, found 'idle'; leave the column out with "
        "--ignore 'flow'",
    ),
    "decimal comma": (
        broken(30, "2020-03-09 10:00:28;1,5;60;0;0"),
        "line 30, column 'flow': expected a number, found '1,5'; .* write a point for decimals",
    ),
    "cells": (
        broken(31, "2020-03-09 10:00:29;1;60"),
        "line 31: expected 5 cells as in the heading, found 3",
    ),
    "time": (
        broken(32, "yesterday;1;60;0;0"),
        "line 32, column 'datetime': expected a time like 2024-01-31T12:00:00Z, found 'yesterday'",
    ),
    "quote": (broken(33, '2020-03-09 10:00:31;"1;60;0;0'), "line 33: expected a row of a CSV"),
    "long line": (broken(34, "1" * 1_000_002), "line 34: .* longer than 1000000 letters"),
    "few rows": (pump_lines()[:50], "expected more than the 100 rows to learn from, found 49"),
}


@pytest.mark.parametrize("case", list(BAD))
def test_a_bad_table_is_refused_with_where_and_what_was_expected(tmp_path, case):
    lines, words = BAD[case]
    with pytest.raises(BadRows, match=rf"pump\.csv.*{words}"):
        backtest(write_table(tmp_path, lines))


def test_files_that_are_missing_or_no_text_are_named(tmp_path):
    with pytest.raises(BadRows, match=r"none\.csv: it cannot be opened: No such file"):
        backtest(str(tmp_path / "none.csv"))
    path = tmp_path / "picture.csv"
    path.write_bytes(b"\x89PNG\xff\xfe\n")
    with pytest.raises(BadRows, match="line 1: expected a row of a CSV table: not UTF-8"):
        backtest(str(path))


def test_what_cannot_be_asked_for_is_told(tmp_path):
    path = write_table(tmp_path, pump_lines())
    with pytest.raises(
        CliError, match="--learn-rows: expected 60 to 30000 for 'group' with 2 signals, found 5"
    ):
        backtest(path, "--learn-rows", "5")
    with pytest.raises(BadRows, match="there is no column 'speed'; there are 'datetime', 'flow'"):
        backtest(path, "--signals", "speed")
    with pytest.raises(CliError, match="expected a zone like Europe/Madrid or UTC, found 'Moon'"):
        backtest(path, "--zone", "Moon")
    wide = ["time," + ",".join(f"s{at}" for at in range(65))]
    with pytest.raises(CliError, match="at most 64 signals for 'group', found 65; choose some"):
        backtest(write_table(tmp_path, wide))


def test_rows_of_a_long_table_are_judged_as_one_by_one_and_late_ones_repeat_the_last(
    tmp_path, capsys
):
    lines = pump_lines(1_300, fault=1_000)
    # Two late ones: one within what is judged at once, and the first of what follows.
    lines[300], lines[513] = lines[10], lines[20]
    # And a value that is not there.
    lines[700] = "2020-03-09 10:11:39;;60.0;0.0;0.0"
    path = write_table(tmp_path, lines)
    assert backtest(path, "--detector", "change", "--rows") == 0
    printed = capsys.readouterr()
    rows = list(csv.DictReader(io.StringIO(printed.out)))
    flow, heat = KINDS["change"].make(), KINDS["change"].make()
    expected, newest = [], ""
    for line in lines[1:]:
        time, *cells = line.split(";")[:3]
        if time > newest:
            newest, at = time, len(expected)
            scores = [
                one.see(at, float(cell)) if cell else 0.0
                for one, cell in zip((flow, heat), cells, strict=True)
            ]
        expected.append(f"{max(scores):.4f}")
    assert [row["score"] for row in rows] == expected
    assert "1" in {row["anomalous"] for row in rows[1_000:1_010]}
    assert printed.err.startswith("not looked at")
    assert "2 rows are not newer" in printed.err


def test_what_was_read_before_a_bad_row_is_printed(tmp_path, capsys):
    lines = pump_lines(700)
    lines[601] = "2020-03-09 10:10:00;much;60.0;0.0;0.0"
    path = write_table(tmp_path, lines)
    with pytest.raises(BadRows, match="line 602"):
        backtest(path, "--detector", "change", "--rows")
    assert len(capsys.readouterr().out.splitlines()) == 601
