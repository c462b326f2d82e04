"""A station behind a real indiserver whose own time stands still while its values go on."""

# ruff: noqa: SIM117 - in a server stands what speaks to it
from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from talaia.wire.frames import InterlockState

from .test_adapter import BARE, bench

if TYPE_CHECKING:
    from collections.abc import Callable

pytestmark = pytest.mark.robot

STATION = (
    BARE
    + """
devices:
  weather:
    name: Weather
    indi: Station
    signals:
      wind:
        name: Wind
        unit: km/h
        max_age: 2
        source:
          {property: WEATHER_PARAMETERS, element: WEATHER_WIND_SPEED, stamp: timestamp}
    commands:
      join: {name: Join, kind: indi, target: CONNECTION, fixed: {CONNECT: true}}
interlocks:
  wind:
    name: Wind
    when: [{signal: weather/wind, above: 45}]
    refuse: [weather/join]
    dwell: 0
"""
)


async def test_a_stamp_that_stands_still_while_messages_arrive_is_unknown(
    indi: Callable, tmp_path: Path
) -> None:
    stands, driver = tmp_path / "stands", tmp_path / "indi_old_station"
    here = str(Path(__file__).parent)
    driver.write_text(
        f"#!{sys.executable}\nimport sys\nfrom pathlib import Path\nsys.path.insert(0, {here!r})\n"
        f"import old_station\nold_station.run(Path({str(stands)!r}))\n"
    )
    driver.chmod(0o755)
    async with indi(str(driver)) as server:
        async with bench(server.port, tmp_path / "data", STATION) as one:
            await one.hub.next(InterlockState, lambda each: not each.locked)
            stands.touch()
            held = await one.hub.next(InterlockState, lambda each: each.locked)
            assert "its own time stamp has stood still" in held.why
            heard = len(one.hub.values("weather/wind"))
            await one.hub.until(lambda: len(one.hub.values("weather/wind")) > heard, "values go on")
            stands.unlink()
            await one.hub.next(InterlockState, lambda each: not each.locked)
