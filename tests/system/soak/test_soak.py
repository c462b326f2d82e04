"""The soak itself runs: a load, kills, samples and a table, in a few seconds."""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ..conftest import missing
from ..stack import SOURCE
from .report import FIGURES

SECONDS = 15


@pytest.mark.robot
def test_a_short_soak_has_every_figure_and_outlives_a_kill(tmp_path: Path) -> None:
    if not importlib.util.find_spec("rclpy"):
        missing("ROS 2 (rclpy)")
    tests = Path(__file__).parents[2]
    table, samples = tmp_path / "table.md", tmp_path / "samples.jsonl"
    words = [sys.executable, "-m", "system.soak", str(SECONDS / 3600)]
    words += ["--table", str(table), "--samples", str(samples)]
    done = subprocess.run(
        words,
        env={**os.environ, "PYTHONPATH": f"{SOURCE}{os.pathsep}{tests}"},
        text=True,
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    said = table.read_text()
    assert "Errors: none." in said
    lines = [json.loads(each) for each in samples.read_text().splitlines()]
    assert lines[-1]["lives"]["hub"] == 1
    assert set().union(*(each["figures"] for each in lines)) >= {*FIGURES}
    assert lines[0]["figures"]["gateway: memory (RSS), MiB"] > 20
    assert lines[0]["figures"]["hub: descriptors"] > 10
    assert max(each["rows"].get("users", 0) for each in lines) == 3
