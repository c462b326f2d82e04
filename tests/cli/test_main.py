"""The command line: its words, its help, and what it says when something is wrong."""

from __future__ import annotations

import importlib
import json
import subprocess
import sys
from pathlib import Path

import pytest

from talaia.cli.main import COMMANDS, main
from talaia.objects import availability

# Each takes from a third of a second to two of a slow core.
HEAVY = (
    "sqlalchemy",
    "fastapi",
    "rclpy",
    "mujoco",
    "av",
    "rosbags",
    "bcrypt",
    "cryptography",
    "pint",
    "numpy",
    "websockets",
    "ruamel.yaml",
    "talaia.model.site",
)
EXAMPLE = Path(__file__).parents[2] / "examples/agv/site.yaml"


def test_help_names_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    said = capsys.readouterr().out
    for name, command in COMMANDS.items():
        assert name in said
        assert command.summary in said


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_a_main_and_its_own_help(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert callable(importlib.import_module(COMMANDS[name].module).main)
    with pytest.raises(SystemExit) as ended:
        main([name, "--help"])
    assert ended.value.code == 0
    assert f"talaia {name}" in capsys.readouterr().out


def test_no_command_imports_a_database_ros_or_the_model_to_read_its_words() -> None:
    words = f"""
import contextlib, io, sys
from talaia.cli.main import COMMANDS, main
for name in COMMANDS:
    completed = ["completion", "--words", name, "-"]
    for words in ([name, "--help"], [name, "--no-such-option"], completed):
        with (
            contextlib.redirect_stdout(io.StringIO()),
            contextlib.redirect_stderr(io.StringIO()),
            contextlib.suppress(SystemExit),
        ):
            main(words)
    for heavy in {HEAVY}:
        assert heavy not in sys.modules, (name, heavy)
"""
    # A process of its own: this one has imported all of them.
    subprocess.run([sys.executable, "-c", words], check=True, timeout=120)


def test_an_unknown_command_is_named_with_the_known_ones(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["hubb"]) == 2
    said = capsys.readouterr().err
    assert "'hubb'" in said
    assert "gateway" in said


def test_check_says_right_of_the_example(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(EXAMPLE)]) == 0
    assert "valid; 4 devices" in capsys.readouterr().out


def test_check_names_the_file_and_the_place_of_every_mistake(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "site.yaml"
    text = EXAMPLE.read_text().replace("unit: m/s\n", "unit: m/z\n")
    path.write_text(text.replace("max_turn: 2.84", "max_turn: 0"))
    assert main(["check", str(path)]) == 1
    said = capsys.readouterr().err
    # A unit that nobody knows is a note of its own.
    assert (said.count("error: "), said.count("note: ")) == (2, 1)
    assert said.count(f"--> {path}:") == said.count("= in $.devices.") == 3
    assert "did you mean 'm/s'?" in said


def test_check_tells_whether_this_machine_could_see_objects(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "site.yaml"
    source = "source: {topic: /i, type: sensor_msgs/msg/Image}"
    path.write_text(
        "talaia: 1\nsite: eyes\nname: Eyes\nros2: {}\n"
        "object_models: {ours: {file: ours.onnx, kind: yolo, classes: [nut]}}\n"
        f"devices: {{c: {{name: C, streams: {{one: {{name: One, {source}, "
        f"detect: {{classes: [dog]}}}}, two: {{name: Two, {source}, "
        "detect: {classes: [nut], model: ours}}}}}\n"
    )
    own = tmp_path / "nanodet.onnx"
    monkeypatch.setattr(availability, "OWN_FILE", own)
    assert main(["check", str(path)]) == 0
    said = capsys.readouterr().out
    assert f"c/one: objects cannot be seen on this machine: {own} is missing; create it:" in said
    assert f"c/two: objects cannot be seen on this machine: {tmp_path / 'ours.onnx'} is" in said
    own.touch()
    assert main(["check", str(path)]) == 0
    assert "c/one: objects can be seen on this machine (dog; at the gateway)" in (
        capsys.readouterr().out
    )


def test_check_tells_whether_a_model_of_ones_own_could_run_on_this_machine(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "site.yaml"
    path.write_text(
        "talaia: 1\nsite: eyes\nname: Eyes\nros2: {}\n"
        "object_models: {ground: {file: g.onnx, kind: segmentation, classes: [a, b]}}\n"
        "devices: {c: {name: C, streams: {one: {name: One, models: {ground: {}}, "
        "source: {topic: /i, type: sensor_msgs/msg/Image}}}}}\n"
    )
    assert main(["check", str(path)]) == 0
    said = capsys.readouterr().out
    file = tmp_path / "g.onnx"
    assert f"c/one: model ground (segmentation) cannot run on this machine: {file} is" in said
    assert "correct object_models.ground.file" in said
    file.touch()
    assert main(["check", str(path)]) == 0
    assert "model ground (segmentation) can run on this machine" in capsys.readouterr().out


def test_schema_is_json_schema_and_the_example_uses_only_its_keys(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["schema"]) == 0
    schema = json.loads(capsys.readouterr().out)
    assert schema["$schema"].startswith("https://json-schema.org/")
    assert {"talaia", "site", "name", "devices"} <= set(schema["$defs"]["Site"]["properties"])


def test_a_gateway_with_a_bad_description_says_where_and_exits_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "site.yaml"
    path.write_text(EXAMPLE.read_text().replace("kind: power", "kind: pwer"))
    key = tmp_path / "key"
    key.write_text("k")
    words = ["gateway", str(path), "--hub", "ws://127.0.0.1:1", "--allow-plain"]
    assert main([*words, "--key-file", str(key), "--data", str(tmp_path)]) == 2
    assert "$.devices.power.kind" in capsys.readouterr().err


def test_a_command_that_cannot_use_a_description_prints_its_mistakes_as_check_does(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "site.yaml"
    wrong = EXAMPLE.read_text().replace("kind: power", "kind: pwer").replace("zone: ", "zone: Mars")
    path.write_text(wrong)
    assert main(["generate", str(path), "--to", str(tmp_path / "out")]) == 2
    told = capsys.readouterr().err
    line = wrong[: wrong.index("kind: pwer")].count("\n") + 1
    assert f"--> {path}:{line}:5\n" in told
    # All of them, and not the first alone.
    assert "unknown time zone 'Mars" in told
    assert f"{path}: 2 mistakes" in told
