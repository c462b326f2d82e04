"""``talaia check``: every mistake in one run, with its line, in words that anybody knows."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from talaia.cli.checking.check import check_file
from talaia.cli.checking.command_line import main
from talaia.model.checks.text_checks import check_text

pytestmark = pytest.mark.pure

EXAMPLE = Path(__file__).parents[3] / "examples" / "agv" / "site.yaml"
COMMAND_FILE = Path(__file__).parents[2] / "wire" / "recorded" / "observatory_commands.json"
HEAD = "talaia: 1\nsite: lab\nname: Lab\nzone: Europe/Madrid\nros2: {}\ndevices:\n  base:\n"
NAMED = "    name: Base\n    signals:\n"
SOURCE = "source: {topic: /odom, type: nav_msgs/msg/Odometry, field: a.b}"
# What somebody wrote below ``devices``, and of each mistake the line, and words of what is told.
MISTAKES = {
    "a speed limit to the base of 60": (
        f"{NAMED}      speed: {{name: S, maximum: 1:30, {SOURCE}}}\n",
        [(10, "expected a number, found the text '1:30'")],
    ),
    "a number with a zero before it": (
        f"{NAMED}      speed: {{name: S, maximum: 010, {SOURCE}}}\n",
        [(10, "expected a number, found the text '010'")],
    ),
    "a number as a name": (
        f"    name: 7\n    signals:\n      speed: {{name: true, {SOURCE}}}\n",
        [(8, "expected a text, found the number 7"), (10, "expected a text, found true")],
    ),
    "several keys that nobody knows": (
        f"{NAMED}      speed: {{name: S, min: 1, max: 2, {SOURCE}}}\n    colour: red\n",
        [(10, "unknown key 'min'"), (10, "unknown key 'max'"), (11, "unknown key 'colour'")],
    ),
    "keys that are missing": (
        "    signals:\n      speed: {unit: m/s}\n",
        [(7, "the key 'name' is missing"), (9, "the key 'name' is missing"),
         (9, "the key 'source' is missing")],
    ),
    "a mistake of shape beside one of sense": (
        f"{NAMED}      Speed: {{name: S, minimum: low, {SOURCE}}}\n",
        [(10, "cannot be a name in an address"), (10, "expected a number, found the text 'low'")],
    ),
    "no YAML": ("    name: [Base\n", [(8, "the [ that begins here is not closed")]),
}  # fmt: skip


@pytest.mark.parametrize("name", MISTAKES)
def test_all_mistakes_are_told_in_one_run_each_with_its_line(name: str) -> None:
    text, expected = MISTAKES[name]
    told = [(each.line, each.problem) for each in check_text(HEAD + text).mistakes]
    for line, words in expected:
        assert any(line == at and words in problem for at, problem in told), (line, words, told)
    assert len(told) == len(expected), told


def test_power_of_ten_is_a_number_and_a_right_text_has_no_mistake() -> None:
    report = check_text(f"{HEAD}{NAMED}      speed: {{name: S, maximum: 1e3, {SOURCE}}}\n")
    assert report.mistakes == []
    assert report.site is not None
    assert report.site.devices["base"].signals["speed"].maximum == 1000.0


def test_mistakes_are_shown_in_their_line_and_as_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "site.yaml"
    file.write_text(
        EXAMPLE.read_text().replace("name: ", "nmae: ", 1).replace("devices:", "devises:")
    )
    assert main([str(file)]) == 1
    told = capsys.readouterr().err
    assert "error: unknown key 'nmae'" in told
    assert f"--> {file}:" in told
    assert "^^^^" in told
    assert "did you mean 'name'?" in told
    assert "did you mean 'devices'?" in told
    assert main(["--json", str(file), str(EXAMPLE)]) == 1
    rows = json.loads(capsys.readouterr().out)
    assert {row["file"] for row in rows} == {str(file)}
    lines = file.read_text().splitlines()
    for row in rows:
        assert row["problem"]
        if "unknown key" in row["problem"]:
            assert lines[row["line"] - 1][row["column"] - 1 :].startswith(
                row["problem"].split("'")[1]
            )


def test_a_file_that_cannot_be_read_is_named_and_the_others_are_checked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(tmp_path / "none.yaml"), str(EXAMPLE)]) == 1
    out = capsys.readouterr()
    assert "error: there is no such file" in out.err
    assert f"{EXAMPLE}: valid" in out.out


def test_devices_of_a_file_that_a_description_takes_in_are_known_to_the_check(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "site.yaml"
    (tmp_path / "commands.json").write_text(COMMAND_FILE.read_text())
    file.write_text(
        "talaia: 1\nsite: obs\nname: Obs\nzone: UTC\n"
        "connections: {old: {kind: process, file: commands.json, prefix: talaia sim run}}\n"
        "alarms: {open: {name: Open, kind: state, signal: dome/status, is: [opened]}}\n"
    )
    assert main([str(file)]) == 0, capsys.readouterr().err
    file.write_text(file.read_text().replace("commands.json", "others.json"))
    assert main([str(file)]) == 1
    told = capsys.readouterr().err
    assert "there is no such file" in told
    assert "others.json" in told


RIGHT = EXAMPLE.read_text()


@pytest.mark.parametrize(
    ("data", "told"),
    [
        (RIGHT.encode("utf-16"), "is UTF-16; save it as UTF-8"),
        (RIGHT.encode("utf-16-le"), "is UTF-16; save it as UTF-8"),
        (b"\x1f\x8b\x08" + bytes(20), "is packed (gzip); unpack it: gunzip"),
        (b"\x7fELF" + bytes(9) + b"\xff", "is a program or data, and no text"),
        (b"#" * (4 * 1024 * 1024 + 1), "is longer than 4 MiB, as no description is"),
        (
            "talaia: 1\nname: Català\n".encode("latin1"),
            "line 2, column 12: a letter that is not written in UTF-8 (the byte 0xE0; for Windows "
            "it is à); save the file as UTF-8",
        ),
    ],
)
def test_what_is_no_text_is_called_what_it_is(data: bytes, told: str, tmp_path: Path) -> None:
    path = tmp_path / "site.yaml"
    path.write_bytes(data)
    (mistake,) = check_file(path).mistakes
    assert told in f"{mistake.where}: {mistake.problem}; {mistake.remedy}".replace(
        f"{path}: is", "is"
    )
    assert (mistake.line, mistake.column) == ((2, 12) if "line" in told else (0, 0))


def test_a_folder_a_pipe_and_a_missing_file_are_told_with_what_to_do(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.yaml"
    os.mkfifo(pipe)
    told = [check_file(path).mistakes[0] for path in (tmp_path, pipe, tmp_path / "site.yaml")]
    assert [one.problem for one in told] == [
        "is not a file, but a folder",
        "is not a file (a pipe, a device)",
        "there is no such file",
    ]
    assert told[2].remedy.endswith("talaia init -o site.yaml")
