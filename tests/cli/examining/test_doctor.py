"""``talaia doctor``: says what is here, what is not, and what to do."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from talaia.cli.examining.doctor import PartState, examine_machine, main
from talaia.ros_installation import find_ros


def test_each_part_is_named_once_and_what_is_not_here_has_a_remedy() -> None:
    findings = list(examine_machine())
    names = [finding.what for finding in findings]
    assert len(set(names)) == len(names)
    assert {"Talaia", "ROS 2", "ROS 1", "INDI server", "hub", "gateway"} <= set(names)
    for finding in findings:
        assert (finding.state is PartState.OK) == (not finding.remedy)


def test_a_domain_that_is_no_number_is_a_problem(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    if not find_ros().wheels:
        pytest.skip("the ROS 2 wheels are not installed")
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    assert main(["--port", "0", "--data", str(tmp_path)]) == 0
    assert "ROS 2 domain           0, for ROS_DOMAIN_ID is not set" in capsys.readouterr().out
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    assert main(["--port", "0", "--data", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "7, by ROS_DOMAIN_ID; only robots on this machine are heard (ROS_AUTO" in said
    monkeypatch.setenv("ROS_DOMAIN_ID", "five")
    assert main(["--port", "0", "--data", str(tmp_path)]) == 1
    said = capsys.readouterr().out
    assert "!!  ROS 2 domain" in said
    assert "→ set it to a number from 0 to 101" in said


def test_a_ros_that_is_sourced_for_another_python_is_told(tmp_path: Path) -> None:
    """As on Ubuntu 22.04, with Humble sourced and Talaia in an environment of a newer Python."""
    packages = tmp_path / "opt/ros/humble/lib/python3.10/site-packages"
    packages.mkdir(parents=True)
    done = subprocess.run(
        [sys.executable, "-m", "talaia", "doctor", "--port", "0", "--data", str(tmp_path)],
        env={
            **os.environ,
            "AMENT_PREFIX_PATH": str(tmp_path / "opt/ros/humble"),
            "PYTHONPATH": os.pathsep.join([str(packages), "src"]),
        },
        cwd=Path(__file__).parents[3],
        capture_output=True,
        text=True,
        check=False,
    )
    line = next(line for line in done.stdout.splitlines() if "  ROS 2  " in line)
    assert "is sourced, and used by a process of its own Python 3.10" in line
    # Here it is an empty folder.
    assert "!!  ROS 2 by its Python" in done.stdout
    assert done.returncode == 1
