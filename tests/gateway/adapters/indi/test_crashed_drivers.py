"""Drivers that crash under a real indiserver: connected and set up again, with nobody there."""

# ruff: noqa: SIM117 - in a server stands what speaks to it
from __future__ import annotations

import asyncio
import math
from typing import TYPE_CHECKING

import pytest

from talaia.wire.frames import CommandPhase, Event, InterlockState

from .test_adapter import BARE, bench

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from indi_server import Server

    from .test_adapter import Bench

pytestmark = pytest.mark.robot

WEATHER = (
    BARE
    + """
devices:
  weather:
    name: Weather
    kind: weather
    indi: Weather Simulator
    setup: {WEATHER_UPDATE: {PERIOD: 2}, GEOGRAPHIC_COORD: {LAT: 42.05, LONG: 0.73}}
    signals:
      wind:
        name: Wind
        unit: km/h
        max_age: 5
        source: {property: WEATHER_PARAMETERS, element: WEATHER_WIND_SPEED}
      period:
        {name: Period, unit: s, max_age: 5, source: {property: WEATHER_UPDATE, element: PERIOD}}
      latitude: {name: Latitude, source: {property: GEOGRAPHIC_COORD, element: LAT}}
      connection:
        name: Driver
        type: state
        states: ["off", "on"]
        source: {property: CONNECTION, element: CONNECT}
    commands:
      leave: {name: Leave, kind: indi, target: CONNECTION, fixed: {DISCONNECT: true}}
      join: {name: Join, kind: indi, target: CONNECTION, fixed: {CONNECT: true}}
  dome:
    name: Dome
    kind: dome
    indi: Dome Simulator
    signals:
      shutter:
        name: Shutter
        type: state
        states: [closed, opening, open, closing, error, unknown]
        max_age: 5
        source: {property: DOME_SHUTTER}
    commands:
      open: {name: Open, kind: indi, target: DOME_SHUTTER, fixed: {SHUTTER_OPEN: true}, timeout: 60}
interlocks:
  weather:
    name: Weather
    when: [{signal: weather/wind, above: 45}]
    refuse: [dome/open]
    dwell: 3
"""
)


def known(one: Bench, address: str) -> bool:
    value = one.newest(address)
    return isinstance(value, float) and math.isfinite(value)


async def crashed(one: Bench, server: Server, name: str, address: str) -> None:
    """Kill a driver, and see that the gateway has noticed."""
    server.kill_driver(name)
    await one.hub.until(lambda: not known(one, address), f"{address} unknown")


async def test_crashed_weather_driver_is_connected_again_and_measures_at_the_described_period(
    indi: Callable, tmp_path: Path
) -> None:
    async with indi("indi_simulator_weather", "indi_simulator_dome") as server:
        async with bench(server.port, tmp_path / "data", WEATHER) as one:
            await one.hub.until(lambda: one.newest("weather/period") == 2.0, "the period")
            await one.hub.until(lambda: one.newest("weather/latitude") == 42.05, "the place")
            await one.hub.until(lambda: known(one, "weather/wind"), "wind")
            for _ in range(2):
                loop = asyncio.get_running_loop()
                began = loop.time()
                await crashed(one, server, "indi_simulator_weather", "weather/wind")
                await one.hub.next(Event, lambda each: each.kind == "driver_restarted")
                refused = await one.does("dome", "open")
                assert refused.phase is CommandPhase.REFUSED, refused.message
                await one.hub.until(lambda: known(one, "weather/wind"), "wind again")
                assert loop.time() - began < 40
                await one.hub.until(lambda: one.newest("weather/period") == 2.0, "the period")
            # A minute was the driver's own period: it must go on without a hole.
            await one.hub.next(InterlockState, lambda each: not each.locked)
            held = len(one.hub.values("weather/wind"))
            opened = await one.does("dome", "open")
            assert opened.phase is CommandPhase.SUCCEEDED, opened.message
            await one.hub.until(lambda: len(one.hub.values("weather/wind")) > held, "more wind")
            assert all(math.isfinite(each) for each in one.hub.values("weather/wind")[held:])


async def test_driver_that_a_person_disconnected_stays_so_through_a_crash_until_one_connects_it(
    indi: Callable, tmp_path: Path
) -> None:
    async with indi("indi_simulator_weather", "indi_simulator_dome") as server:
        async with bench(server.port, tmp_path / "data", WEATHER) as one:
            await one.until_state("weather/connection", "on")
            await one.does("weather", "leave")
            await one.until_state("weather/connection", "off")
            server.kill_driver("indi_simulator_weather")
            # The other driver is connected again meanwhile: this one had as long, and is left.
            await crashed(one, server, "indi_simulator_dome", "dome/shutter")
            await one.hub.until(lambda: known(one, "dome/shutter"), "shutter again")
            assert one.state("weather/connection") == "off"
            await one.does("weather", "join")
            await one.until_state("weather/connection", "on")
            await one.hub.until(lambda: one.newest("weather/period") == 2.0, "the period")


async def test_camera_whose_driver_crashes_by_itself_takes_pictures_again(
    indi: Callable, tmp_path: Path
) -> None:
    async with indi("indi_simulator_ccd") as server:
        async with bench(server.port, tmp_path / "data", CAMERA) as one:
            await one.hub.until(lambda: known(one, "camera/temperature"), "a temperature")
            await one.ask("camera", "crash")
            await one.hub.until(lambda: not known(one, "camera/temperature"), "no temperature")
            await one.hub.until(lambda: known(one, "camera/temperature"), "a temperature again")
            shot = await one.does("camera", "expose", seconds=0.1)
            assert shot.phase is CommandPhase.SUCCEEDED, shot.message


CAMERA = (
    BARE
    + """
devices:
  camera:
    name: Camera
    kind: camera
    indi: CCD Simulator
    signals:
      temperature:
        name: Sensor
        unit: °C
        source: {property: CCD_TEMPERATURE, element: CCD_TEMPERATURE_VALUE}
    commands:
      crash: {name: Crash, kind: indi, target: CCD_SIMULATE_CRASH, fixed: {CRASH: true}}
      expose:
        name: Expose
        kind: indi
        target: CCD_EXPOSURE
        timeout: 60
        arguments: {seconds: {type: number, field: CCD_EXPOSURE_VALUE, unit: s}}
"""
)
