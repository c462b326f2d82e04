"""From robots of every kind to their dashboards, by ``talaia init`` and ``talaia up`` alone.

The unknown robot has `test_up`. None of these touches the description between the two words.
"""

from __future__ import annotations

import asyncio
import importlib.util
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from ports import free_port

sys.path.insert(0, str(Path(__file__).parents[1] / "gateway"))
sys.path.insert(0, str(Path(__file__).parents[1] / "gateway/adapters/indi"))
sys.path.insert(0, str(Path(__file__).parents[1] / "gateway/adapters/ros1"))
import ros1_bench
from indi_server import server_of

from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.load import read_site
from talaia.sim import ros_domain

from .conftest import missing
from .walk import stored, talaia, until_stored, up, walked

pytestmark = pytest.mark.robot
HERE = Path(__file__).parent
MINUTE = 60.0


@contextmanager
def running(words: list[str], here: dict[str, str], ready: str) -> Iterator[None]:
    """Run a robot until the end of the test; it has begun when it says so."""
    process = subprocess.Popen(words, env=here, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    try:
        assert any(ready in line for line in process.stdout), f"{words} ended"
        yield
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


@contextmanager
def ros2_world() -> Iterator[tuple[dict[str, str], int]]:
    for module in ("rclpy", "mujoco"):
        if not importlib.util.find_spec(module):
            missing(module)
    with ros_domain.reserve_domain() as place:
        here = {
            **os.environ,
            **ros_domain.domain_environment(place.domain),
            "PYTHONUNBUFFERED": "1",
        }
        here.pop("ROS_MASTER_URI", None)
        yield here, place.domain


@contextmanager
def ros1_world(folder: Path) -> Iterator[dict[str, str]]:
    ros1_bench.need_ros1()
    port = free_port()
    with ros1_bench.master(port, folder):
        world = ros1_bench.environment(port, folder)
        yield {
            **os.environ,
            **{key: world[key] for key in ("ROS_MASTER_URI", "ROS_IP", "ROS_HOME")},
        }


@pytest.mark.parametrize(
    ("robot", "words", "least"),
    [("vehicle", ("--no-camera",), 30), ("observatory", (), 30)],
)
def test_a_simulated_robot_has_every_number_in_its_history_within_a_minute(
    robot: str, words: tuple[str, ...], least: int, tmp_path: Path
) -> None:
    with ros2_world() as (here, number):
        start = [sys.executable, "-m", "talaia", "sim", robot, "--domain", str(number), *words]
        with running(start, here, '"ready"'), walked(here, tmp_path, "--site", robot) as site:
            wanted = site.numbers()
            assert len(wanted) >= least
            until_stored(site.client, robot, wanted)
            assert site.seconds() < MINUTE
            site.tell()


@pytest.mark.parametrize("connect", [True, False], ids=["connected", "not_connected"])
async def test_an_indi_observatory_has_its_numbers_in_the_history_within_a_minute(
    *, connect: bool, tmp_path: Path
) -> None:
    drivers = [f"indi_simulator_{each}" for each in ("telescope", "dome", "ccd", "weather")]
    async with server_of(tmp_path, *drivers) as server:
        more = ["--connect"] if connect else []
        words = ["--indi", f"127.0.0.1:{server.port}", *more, "--site", "sky"]
        await asyncio.to_thread(_observatory, words, tmp_path, connect=connect)


def _observatory(words: list[str], folder: Path, *, connect: bool) -> None:
    with walked(dict(os.environ), folder, *words) as site:
        devices = {"telescope_simulator", "dome_simulator", "ccd_simulator", "weather_simulator"}
        if connect:
            assert set(site.site.devices) == devices
        else:
            # The gateway has connected the drivers, and describes them by itself.
            assert site.site.devices == {}
        wanted = {"telescope_simulator/ra", "telescope_simulator/dec", "dome_simulator/azimuth",
                  "weather_simulator/temperature"}  # fmt: skip
        if connect:
            wanted |= site.numbers() - NEVER
        until_stored(site.client, "sky", wanted)
        assert site.seconds() < MINUTE
        site.tell()


NEVER: set[str] = set()


@pytest.mark.parametrize("ros", ["ros1", "ros2"])
def test_a_cloudconnect_vehicle_is_recognised_by_itself(ros: str, tmp_path: Path) -> None:
    script = str(HERE / "cloudconnect_robot.py")
    if ros == "ros1":
        with ros1_world(tmp_path) as here:
            robot = {**here, "PATH": "/usr/bin:/bin"}
            with running([ros1_bench.PYTHON, script, ros], robot, "ready"):
                # ROS_MASTER_URI says where to look; nothing else does.
                _cloudconnect(here, tmp_path)
        return
    with ros2_world() as (here, _), running([sys.executable, script, ros], here, "ready"):
        _cloudconnect(here, tmp_path)


def _cloudconnect(here: dict[str, str], folder: Path) -> None:
    with walked(here, folder, "--site", "cart") as cart:
        signals = {
            each.source.name: f"{device}/{word}"
            for device, one in cart.site.devices.items()
            for word, each in one.signals.items()
        }
        assert set(signals) == {"speed1", "ultrasonic2", "temperature1"}
        streams = [each for one in cart.site.devices.values() for each in one.streams.values()]
        assert [each.source.topic for each in streams] == ["/images"]
        (drive,) = [one.drive for one in cart.site.devices.values() if one.drive is not None]
        assert (drive.topic, drive.message) == ("/control", "std_msgs/msg/String")
        until_stored(cart.client, "cart", signals.values())
        found = stored(cart.client, "cart", signals.values())
        assert found[signals["temperature1"]]["v"] == 21.5
        cart.tell()


def test_a_ros1_robot_is_looked_at_listed_and_described(tmp_path: Path) -> None:
    with ros1_world(tmp_path) as here:
        robot = {**here, "PATH": "/usr/bin:/bin"}
        with running(
            [ros1_bench.PYTHON, str(HERE / "cloudconnect_robot.py"), "ros1"], robot, "ready"
        ):
            told = talaia(here, "probe", "--ros1", "--fields", "--seconds", "2")
            probed = talaia(here, "probe", "--ros1", here["ROS_MASTER_URI"], "--json")
    assert told.returncode == 0, told.stderr
    assert "/metric" in told.stdout
    assert "ultrasonic2" in told.stdout
    assert "cameras      /images" in told.stdout
    target = tmp_path / "site.yaml"
    elsewhere = {key: each for key, each in os.environ.items() if key != "ROS_MASTER_URI"}
    made = talaia(elsewhere, "init", "--found", "-", "-o", str(target), given=probed.stdout)
    assert made.returncode == 0, made.stderr
    site = read_site(target)
    assert check_site(site) == []
    assert site.connections["ros1"].master == here["ROS_MASTER_URI"]


COUNTING = """
talaia: 1
site: plain
name: Plain
connections: {commands: {kind: process, poll: 0.2}}
devices:
  clock:
    name: Clock
    signals:
      seconds: {name: Seconds, source: {run: "date +%s"}}
"""


def test_up_goes_on_with_the_same_gateway_and_the_history_of_before(tmp_path: Path) -> None:
    target, data = tmp_path / "site.yaml", tmp_path / "data"
    target.write_text(COUNTING)
    here = dict(os.environ)
    with up(here, target, data) as (client, _):
        until_stored(client, "plain", ["clock/seconds"])
        first = stored(client, "plain", ["clock/seconds"])["clock/seconds"]
        gateways = client.get("/api/gateways").json()
    key = (data / "gateway.key").read_text()
    assert (data / "gateway.key").stat().st_mode & 0o777 == 0o600
    with up(here, target, data) as (client, _):
        before = {"before_us": str(first["t_us"] + 1), "channel": "clock/seconds"}
        kept = client.get("/api/sites/plain/last", params=before).json()["values"]
        assert [each["v"] for each in kept] == [first["v"]]
        again = client.get("/api/gateways").json()
        assert _names(again) == _names(gateways)
    assert (data / "gateway.key").read_text() == key


def _names(answer: dict[str, list[dict[str, object]]]) -> list[tuple[object, object]]:
    return [(each["id"], each["revoked_us"]) for each in answer["gateways"]]
