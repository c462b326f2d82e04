"""Clouds that only the all-sky camera sees close what an interlock forbids by them: real ROS 2."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace
from patience import PATIENCE_S

from talaia.model.interlocks.interlock import Condition, Interlock
from talaia.model.yaml_text.load import dump_site, load_site

from .conftest import need_ros2
from .observatory import EXAMPLE, Observatory

pytestmark = pytest.mark.robot


async def test_an_interlock_goes_by_the_clouds_that_the_camera_sees(tmp_path: Path) -> None:
    need_ros2()
    site = load_site(EXAMPLE.read_text())
    sky = Interlock(
        name="Seen clouds",
        when=(Condition(signal="allsky/clouds", above=70.0, until_below=50.0),),
        refuse=("dome/open",),
        dwell=2.0,
    )
    allsky = site.devices["allsky"]
    often = replace(allsky.streams["sky"], sky=replace(allsky.streams["sky"].sky, every=1.0))
    devices = {**site.devices, "allsky": replace(allsky, streams={"sky": often})}
    described = dump_site(
        replace(site, devices=devices, interlocks={**site.interlocks, "sky": sky})
    )
    # A picture in twenty seconds of the simulator's.
    observatory = Observatory(tmp_path, described, speed=20)
    try:
        await observatory.parts[0].says("ready")
        observatory.start_gateway()
        await observatory.told("interlock_released  sky", PATIENCE_S)
        observatory.order("weather clouds")
        await observatory.told("interlock_locked  sky", PATIENCE_S)
    finally:
        observatory.close()
