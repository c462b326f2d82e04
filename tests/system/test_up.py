"""From a robot that no code here knows to its dashboard: probe, init, up, and a browser."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from patience import PATIENCE_MS
from playwright.sync_api import Browser, expect

from talaia.model.checks.site_checks import check_site
from talaia.model.connection import RosSource, Source
from talaia.model.yaml_text.load import read_site
from talaia.sim import ros_domain

from .conftest import missing
from .pages import sign_in
from .walk import PASSWORD, talaia, until_stored, walked

pytestmark = pytest.mark.robot


@pytest.fixture(scope="module")
def robot() -> Iterator[dict[str, str]]:
    """The unknown robot, running; gives the environment that reaches it."""
    if not importlib.util.find_spec("rclpy"):
        missing("rclpy")
    place = ros_domain.reserve_domain()
    here = {**os.environ, **ros_domain.domain_environment(place.domain), "PYTHONUNBUFFERED": "1"}
    script = Path(__file__).with_name("unknown_robot.py")
    process = subprocess.Popen(
        [sys.executable, str(script)], env=here, stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline().strip() == "ready"
        yield here
    finally:
        process.kill()
        process.wait()
        assert process.stdout is not None
        process.stdout.close()


def test_what_a_probe_writes_on_the_robot_becomes_a_description_elsewhere(
    robot: dict[str, str], tmp_path: Path
) -> None:
    probed = talaia(robot, "probe", "--json", "--seconds", "4")
    assert probed.returncode == 0, probed.stderr
    found = {each["topic"]: each for each in json.loads(probed.stdout)["topics"]}
    assert 5 < found["/rover/odom"]["rate"] < 15
    target = tmp_path / "site.yaml"
    made = talaia(robot, "init", "--found", "-", "-o", str(target), given=probed.stdout)
    assert made.returncode == 0, made.stderr
    site = read_site(target)
    assert check_site(site) == []
    assert site.devices["rover_power"].signals["charge_level"].scale == 100.0
    assert site.devices["rover_power"].signals["power_supply_status"].states[2] == "Discharging"
    assert site.devices["rover_base"].drive is not None
    # What shares the namespace of what drives is a part of it.
    assert set(site.devices["rover_base"].commands) == {"count", "home"}
    again = talaia(robot, "init", "--found", "-", "-o", str(target), given=probed.stdout)
    assert again.returncode == 2
    assert "--force" in again.stderr


def test_something_else_than_a_probe_is_told_and_nothing_is_written(tmp_path: Path) -> None:
    target = tmp_path / "site.yaml"
    for given, said in (("{", "probe --json"), ('{"talaia_probe": 1}', "probe --json"), (
        '{"talaia_probe": 9, "protocol": "ros2", "where": "x", "seconds": 1}', "form 9"
    )):  # fmt: skip
        made = talaia(dict(os.environ), "init", "--found", "-", "-o", str(target), given=given)
        assert made.returncode == 2
        assert said in made.stderr
    assert not target.exists()


@pytest.mark.browser
def test_an_unknown_robot_has_a_dashboard_with_every_numeric_field_within_a_minute(
    robot: dict[str, str],
    tmp_path: Path,
    # Whoever sits there has one open already.
    chrome: Browser,
) -> None:
    with walked(robot, tmp_path, "--site", "rover", "--name", "Rover") as rover:
        page = chrome.new_page(viewport={"width": 1440, "height": 1000})
        page.set_default_timeout(PATIENCE_MS)
        sign_in(page, rover, "ada", PASSWORD)
        expect(page.get_by_role("heading", name="Rover").first).to_be_visible()
        expect(page.get_by_text("50.0").first).to_be_visible()
        never = {
            f"{device}/{name}"
            for device, each in rover.site.devices.items()
            for name, one in each.signals.items()
            if _never(one.source)
        }
        wanted = rover.numbers() - never
        assert len(wanted) > 150
        until_stored(rover.client, "rover", wanted)
        assert rover.seconds() < 60
        rover.tell()


def _never(source: Source) -> bool:
    """Tell whether this robot only ever says NaN there."""
    assert isinstance(source, RosSource)
    return "battery" in source.topic and source.field == "temperature"
