"""A gateway that is dead or stands still: who closes the roof, as its own sensor says.

Time is that of the simulator's ledger (monotonic), never that of this test's process.
"""

from __future__ import annotations

import asyncio
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import msgspec
import psutil
import pytest

from talaia.model.yaml_text.load import dump_site, load_site

sys.path.insert(0, str(Path(__file__).parents[1] / "gateway"))
from observatory_site import as_ros1

from .conftest import need_ros1, need_ros2
from .observatory import EXAMPLE, Observatory
from .stack import Process, until

pytestmark = [pytest.mark.robot, pytest.mark.timeout(150)]
# What the description says, in place of its 10 s.
AFTER_S = 4.0
# The process that closes has to start, join the robot's protocol and hear its sensors.
JOIN_S = 20.0
PARK_AND_CLOSE_S = 60.0


@pytest.fixture(params=["ROS 2"])
def site(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Observatory]:
    quick = re.sub(r"dwell: \d+", "dwell: 1", EXAMPLE.read_text())
    ros1 = request.param == "ROS 1"
    need_ros1() if ros1 else need_ros2()
    described = load_site(quick)
    rule = msgspec.structs.replace(
        described.enclosures["dome"], watchdog_after=AFTER_S, heartbeat=None
    )
    described = msgspec.structs.replace(described, enclosures={"dome": rule})
    text = dump_site(as_ros1(described) if ros1 else described)
    running = Observatory(tmp_path, text, ros1=ros1)
    try:
        yield running
    finally:
        running.close()


async def supervised(site: Observatory) -> Process:
    """The roof is open under a gateway that supervises it and has its watchdog."""
    await site.parts[0].says("ready")
    gateway = site.start_gateway()
    await gateway.says("interlock_released  rain")
    await gateway.says("interlock_released  weather")
    await gateway.says("interlock_released  daylight")
    # Not before: a gateway that takes long to hear the weather closes an open roof.
    assert "the dome is opened" in site.client("dome_servcli", "client", "open")
    assert "not parked" in site.client("telescope_servcli", "client", "unpark")
    await until(lambda: watchdog_of(site), 30, "a watchdog")
    return gateway


def watchdog_of(site: Observatory) -> int:
    try:
        pid = int((site.folder / "gateway" / "watchdog.lock").read_text() or 0)
    except (FileNotFoundError, ValueError):
        return 0
    return pid if alive(pid) else 0


def alive(pid: int) -> bool:
    """Whether a process runs; one that nobody has waited for yet does not."""
    try:
        return psutil.Process(pid).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


def closed_at(site: Observatory, since: int) -> int:
    """When the shutter had closed, by the simulator (monotonic, ns); 0: not yet."""
    return next((x["t"] for x in site.asked("dome", "close", since) if x["phase"] == "done"), 0)


@pytest.mark.parametrize("site", ["ROS 2", "ROS 1"], indirect=True)
async def test_a_killed_gateway_leaves_a_watchdog_that_closes_the_roof(site: Observatory) -> None:
    gateway = await supervised(site)
    watchdog = watchdog_of(site)
    # What waits for years takes little.
    assert psutil.Process(watchdog).memory_info().rss < 24e6
    since = gateway.kill()
    await site.cause_fault("weather rain")
    await until(lambda: closed_at(site, since), 90, "the dome closed")
    took = (closed_at(site, since) - since) / 1e9
    assert took < AFTER_S + JOIN_S + PARK_AND_CLOSE_S
    # By its own clock: how long before its end a busy machine last let the gateway beat is not
    # known here.
    assert AFTER_S <= site.silence_before_closing_s() < AFTER_S + 2
    parked = [x["t"] for x in site.asked("telescope", "park", since) if x["phase"] == "done"]
    assert parked
    assert parked[0] < closed_at(site, since)
    # With nothing left to do, and nobody to wait for, it leaves.
    await until(lambda: not watchdog_of(site), 60, "the watchdog left")


async def test_a_frozen_gateway_is_closed_for_and_takes_over_when_it_thaws(
    site: Observatory,
) -> None:
    gateway = await supervised(site)
    since = time.monotonic_ns()
    os.kill(gateway.popen.pid, signal.SIGSTOP)
    try:
        await site.cause_fault("weather rain")
        await until(lambda: closed_at(site, since), 90, "the dome closed")
    finally:
        os.kill(gateway.popen.pid, signal.SIGCONT)
    # It is told at the hub what was done meanwhile, and the watchdog watches on.
    await site.told("watchdog_closes watchdog: the gateway is dead", 60)
    watchdog = watchdog_of(site)
    assert watchdog
    beside = psutil.Process(watchdog)
    await until(lambda: not beside.children(), 20, "nothing closes beside the gateway")
    gateway.end()
    assert not alive(watchdog), "an orderly stop says goodbye"


async def test_a_gateway_that_starts_anew_takes_over_from_its_watchdog(site: Observatory) -> None:
    gateway = await supervised(site)
    before = watchdog_of(site)
    since = gateway.kill()
    # As frozen as the gateway was: it cannot hear a goodbye, and must not act on it later.
    os.kill(before, signal.SIGSTOP)
    again = site.start_gateway()
    await until(lambda: watchdog_of(site) not in {0, before}, 60, "a new watchdog")
    assert not alive(before)
    again.end()
    assert not watchdog_of(site)
    assert not closed_at(site, since)


async def test_a_watchdog_that_dies_is_begun_anew_and_never_runs_twice(site: Observatory) -> None:
    await supervised(site)
    before = watchdog_of(site)
    lock = site.folder / "gateway" / "watchdog.lock"
    words = [sys.executable, "-m", "talaia.gateway.watchdog.child", str(lock)]
    second = await asyncio.to_thread(subprocess.call, words, stdin=subprocess.DEVNULL)
    assert second == 3
    assert watchdog_of(site) == before
    os.kill(before, signal.SIGKILL)
    await until(lambda: watchdog_of(site) not in {0, before}, 60, "a new watchdog")


@pytest.fixture
def with_heartbeat(tmp_path: Path) -> Iterator[Observatory]:
    need_ros2()
    quick = load_site(re.sub(r"dwell: \d+", "dwell: 1", EXAMPLE.read_text()))
    rule = msgspec.structs.replace(quick.enclosures["dome"], watchdog_after=0)
    assert rule.heartbeat is not None
    quick = msgspec.structs.replace(quick, enclosures={"dome": rule})
    running = Observatory(tmp_path, dump_site(quick))
    try:
        yield running
    finally:
        running.close()


async def test_a_dome_that_misses_the_heartbeat_of_a_frozen_gateway_closes_by_itself(
    with_heartbeat: Observatory,
) -> None:
    site = with_heartbeat
    await site.parts[0].says("ready")
    gateway = site.start_gateway()
    await gateway.says("interlock_released  rain")
    await gateway.says("interlock_released  weather")
    await gateway.says("interlock_released  daylight")
    # Not before: a gateway that takes long to hear the weather closes an open roof.
    assert "the dome is opened" in site.client("dome_servcli", "client", "open")
    before = len(site.asked("dome", "heartbeat"))
    await until(lambda: len(site.asked("dome", "heartbeat")) > before + 7, 60, "heartbeats")
    assert not watchdog_of(site), "its description wants none"
    # Longer than the controller's patience, and the roof is open still.
    assert not site.asked("dome", "close")
    os.kill(gateway.popen.pid, signal.SIGSTOP)
    try:
        await until(lambda: closed_at(site, 0), 60, "the dome closed")
    finally:
        os.kill(gateway.popen.pid, signal.SIGCONT)
    last = site.asked("dome", "heartbeat")[-1]["t"]
    # 10 s of silence, then 12 s of shutter at four times the speed.
    assert 9 < (closed_at(site, 0) - last) / 1e9 < 25
    assert site.asked("dome", "close")[0]["said"] == "by itself: no heartbeat"


async def test_a_gateway_that_cannot_read_the_domes_sensors_sends_it_no_heartbeat(
    with_heartbeat: Observatory,
) -> None:
    site = with_heartbeat
    await site.parts[0].says("ready")
    gateway = site.start_gateway()
    await until(lambda: len(site.asked("dome", "heartbeat")) > 2, 60, "heartbeats")
    await site.cause_fault("dome hang")
    await gateway.says("heartbeat_withheld  Dome: its sensors say nothing")
    await site.cause_fault("dome ok")
    await gateway.says("heartbeat_sent_again  Dome")
