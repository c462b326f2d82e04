"""``talaia demo-indi`` as a person meets it: it starts, a dome turns, and nothing is left of it."""

from __future__ import annotations

import re
import socket
import subprocess
import time
from pathlib import Path

import httpx
import psutil
import pytest
from patience import PATIENCE_S
from shared_trust import usual_trust
from websockets.asyncio.client import connect

from talaia.cli.demo.indi import DRIVERS
from talaia.model.units import astronomy
from talaia.model.yaml_text.load import read_site
from talaia.wire import browser

from .conftest import Demo, begin_demo, need_indi, stop_demo
from .people import Page

pytestmark = pytest.mark.robot


async def turn(demo: Demo, degrees: float) -> browser.CommandUpdate:
    """Let the operator turn the dome, as the page does, and wait for the end."""
    async with httpx.AsyncClient(
        base_url=demo.address, timeout=PATIENCE_S, verify=usual_trust()
    ) as client:
        page = await client.get("/")
        assert "<title>" in page.text
        words = {"name": "operator", "password": demo.passwords["operator"]}
        answer = await client.post("/api/login", json=words, headers={"Origin": demo.address})
        assert answer.status_code == 200
        cookie = "; ".join(f"{key}={value}" for key, value in client.cookies.items())
    place = demo.address.replace("http", "ws", 1)
    async with connect(
        f"{place}/ws",
        additional_headers={"Cookie": cookie},
        origin=demo.address,  # type: ignore[arg-type]
    ) as socket_:
        person = Page(socket_)
        await person.online()
        await person.say(
            browser.PageCommand(
                site="indi", device="dome", command="goto", id="turn", args={"azimuth": degrees}
            )
        )
        return await person.sees(
            browser.CommandUpdate, lambda x: x.phase not in ("accepted", "running"), within=40
        )


def simulator(demo: Demo, asked: str) -> float:
    """What a simulator itself says."""
    found = re.search(r"port: (\d+)", (demo.data / "site.yaml").read_text())
    assert found is not None
    words = ["indi_getprop", "-1", "-p", found[1], asked]
    return float(subprocess.run(words, capture_output=True, timeout=PATIENCE_S, check=True).stdout)


async def test_the_demo_starts_turns_a_dome_and_ends_with_everything_it_started(
    tmp_path: Path,
) -> None:
    need_indi(*DRIVERS, "indi_getprop", "indi_setprop")
    demo = begin_demo("demo-indi", tmp_path)
    family = psutil.Process(demo.process.pid).children(recursive=True)
    try:
        # The server and its drivers, the hub, the gateway.
        assert len(family) >= len(DRIVERS) + 3
        assert demo.data.parent == tmp_path
        done = await turn(demo, 30.0)
        assert (done.phase, done.message) == ("succeeded", done.message)
        assert simulator(demo, "Dome Simulator.ABS_DOME_POSITION.DOME_ABSOLUTE_POSITION") == 30.0
        # It stands where it is night, so that its roof may be opened; and its mount stands there.
        place = read_site(demo.data / "site.yaml").place
        assert place is not None
        jd = astronomy.julian_day(time.time())
        here = astronomy.Observer(place.latitude, place.longitude, place.elevation)
        assert astronomy.equatorial_to_horizontal(*astronomy.sun_position(jd), here, jd).alt < -8
        # Its station measures humidity, so that dew closes the roof.
        assert 5 <= simulator(demo, "Weather Watcher.WEATHER_PARAMETERS.WEATHER_HUMIDITY") <= 100
        longitude = simulator(demo, "Telescope Simulator.GEOGRAPHIC_COORD.LONG")
        assert longitude == pytest.approx(place.longitude % 360.0, abs=0.01)
    finally:
        code = stop_demo(demo)
    assert code == 0
    _, alive = psutil.wait_procs(family, timeout=PATIENCE_S)
    assert alive == []
    assert not demo.data.exists()
    port = int(demo.address.rsplit(":", 1)[1])
    with socket.socket() as probe:
        assert probe.connect_ex(("127.0.0.1", port)) != 0
