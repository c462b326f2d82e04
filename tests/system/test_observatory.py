"""The observatory's own safety through the real chain: ROS servers, a gateway, and no hub.

The same on INDI's simulators: `tests/gateway/adapters/indi/test_adapter.py`.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from talaia.model.yaml_text.load import dump_site, load_site

sys.path.insert(0, str(Path(__file__).parents[1] / "gateway"))
from observatory_site import as_ros1

from .conftest import need_ros1, need_ros2
from .observatory import EXAMPLE, Observatory
from .stack import until

pytestmark = pytest.mark.robot


@pytest.fixture(params=["ROS 2"])
def site(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Observatory]:
    # The locks of the start are not waited for that long here.
    quick = re.sub(r"dwell: \d+", "dwell: 1", EXAMPLE.read_text())
    ros1 = request.param == "ROS 1"
    if ros1:
        need_ros1()
        quick = dump_site(as_ros1(load_site(quick)))
    else:
        need_ros2()
    running = Observatory(tmp_path, quick, ros1=ros1)
    try:
        yield running
    finally:
        running.close()


async def observing(site: Observatory) -> int:
    """Someone on site has opened and observes; the gateway watches and has no hub."""
    await site.parts[0].says("ready")
    assert "the dome is opened" in site.client("dome_servcli", "client", "open")
    assert "not parked" in site.client("telescope_servcli", "client", "unpark")
    # Due north, where the Sun never is.
    assert "Alt:70" in site.client("telescope_servcli", "client", "goto_altaz", "70", "0")
    gateway = site.start_gateway()
    await gateway.says("interlock_released  rain")
    await gateway.says("interlock_released  weather")
    await gateway.says("interlock_released  daylight")
    return site.ledger()[-1]["t"]


def closed(site: Observatory, since: int) -> bool:
    return any(each["phase"] == "done" for each in site.asked("dome", "close", since))


@pytest.mark.parametrize("site", ["ROS 2", "ROS 1"], indirect=True)
async def test_rain_without_a_hub_aborts_parks_and_closes_within_the_bound(
    site: Observatory,
) -> None:
    since = await observing(site)
    site.fault("weather rain")
    await until(lambda: closed(site, since), what="the dome closed")
    began = site.asked("weather", "rain")[0]["t"]
    interesting = {("camera", "abort"), ("telescope", "park"), ("dome", "close")}
    order = [
        (each["device"], each["asked"], each["phase"])
        for each in site.ledger()
        if each["t"] > began and (each["device"], each["asked"]) in interesting
    ]
    assert order[:5] == [
        ("camera", "abort", "answered"),
        ("telescope", "park", "asked"),
        ("telescope", "park", "done"),
        ("dome", "close", "asked"),
        ("dome", "close", "done"),
    ]
    # The description's bound: 30 s for the telescope, 30 s for the shutter.
    assert (site.asked("dome", "close")[-1]["t"] - began) / 1e9 < 60
    await site.told("enclosure_closed", 10)
    # Opened again by a hand that does not ask the gateway: closed again.
    opened = site.ledger()[-1]["t"]
    site.client("dome_servcli", "client", "open")
    await until(lambda: closed(site, opened), what="closed again")


async def test_a_weather_station_that_falls_silent_closes_as_rain_does(site: Observatory) -> None:
    since = await observing(site)
    await site.cause_fault("weather hang")
    await until(lambda: closed(site, since), what="the dome closed")
    assert any("no value newer than" in line for line in site.note("enclosure_closes"))


async def test_a_stuck_shutter_is_tried_again_and_then_an_alarm_says_not_closed(
    site: Observatory,
) -> None:
    since = await observing(site)
    await site.cause_fault("dome stuck")
    await site.cause_fault("weather rain")
    await site.told("NOT CLOSED after 3 tries", 90)
    assert len(site.asked("dome", "close", since)) >= 4
    await site.cause_fault("dome ok")
    await site.told("alarm_over", 60)
    assert site.asked("dome", "close")[-1]["said"] == "the dome is closed"


async def test_by_day_it_stays_closed_and_at_dawn_it_closes(tmp_path: Path) -> None:
    need_ros2()
    quick = re.sub(r"dwell: \d+", "dwell: 1", EXAMPLE.read_text())
    by_day = Observatory(tmp_path, quick, hours=12)
    try:
        await by_day.parts[0].says("ready")
        assert "the dome is opened" in by_day.client("dome_servcli", "client", "open")
        by_day.start_gateway()
        await until(lambda: closed(by_day, 0), what="the dome closed")
        assert any("The Sun's altitude is above -6" in x for x in by_day.note("enclosure_closes"))
    finally:
        by_day.close()
