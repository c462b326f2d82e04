"""A camera that looks at the sky tells its clouds as a signal."""

from __future__ import annotations

import asyncio
import contextlib
from pathlib import Path

import numpy as np
import pytest

from talaia.clock import HandClock
from talaia.gateway.detection.sky_watch import SkyWatch
from talaia.gateway.ports import CameraFrame
from talaia.gateway.samples.channel_numbering import ChannelNumbering
from talaia.model.yaml_text.load import load_site
from talaia.sim.observatory.models.all_sky import SkyView, draw_sky
from talaia.sim.observatory.servers.devices import MONTSEC

from .one_picture import OnePicture

EXAMPLE = Path(__file__).parents[3] / "examples" / "observatory" / "site.yaml"
NIGHT = 1_794_348_000


def sky_picture(unix: float, clouds: float) -> CameraFrame:
    grey = draw_sky(SkyView(MONTSEC, unix, clouds, 1))
    rgb = np.repeat(grey[:, :, None], 3, axis=2)
    return CameraFrame("allsky/sky", 1, round(unix * 1e6), 5_000_000, rgb)


@pytest.mark.parametrize("clouds", [10.0, 90.0])
async def test_clouds_are_told_as_a_sample_and_as_a_reading_of_the_pictures_time(clouds) -> None:
    site = load_site(EXAMPLE.read_text())
    numbers, camera = (
        ChannelNumbering(site).numbers_of(site),
        OnePicture(sky_picture(NIGHT, clouds)),
    )
    told: asyncio.Future = asyncio.get_running_loop().create_future()
    watch = SkyWatch(
        site=site, numbers=numbers, pictures=camera, clock=HandClock(),
        publish=lambda columns, readings: told.set_result((columns, readings)),
    )  # fmt: skip
    running = asyncio.ensure_future(watch.run())
    columns, readings = await told
    assert columns.channel.tolist() == [numbers["allsky/clouds"]]
    assert columns.value[0] == pytest.approx(clouds, abs=20.0)
    assert columns.time_us[0] == NIGHT * 1_000_000
    assert readings["allsky/clouds"].mono_ns == 5_000_000_000
    assert camera.held == 1
    running.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await running
    assert camera.held == 0
