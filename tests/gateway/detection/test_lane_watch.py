"""A camera that looks at the lane tells where the vehicle is in it, by the simulator's truth."""

from __future__ import annotations

import asyncio
import contextlib
import math
from typing import TYPE_CHECKING

import pytest
from tests.sim.conftest import missing

from talaia.clock import HandClock
from talaia.gateway.detection.lane_watch import LaneWatch
from talaia.gateway.ports import CameraFrame
from talaia.gateway.samples.channel_numbering import ChannelNumbering
from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.load import load_site
from talaia.sim.errors import NoRenderer
from talaia.sim.vehicle.camera import HEIGHT, WIDTH, Camera
from talaia.sim.vehicle.house import LANE_Y
from talaia.sim.vehicle.vehicle import CAMERA_AT, CAMERA_FIELD
from talaia.sim.vehicle.world import World

from .one_picture import OnePicture

if TYPE_CHECKING:
    from collections.abc import Iterator

FOCAL = HEIGHT / 2 / math.tan(math.radians(CAMERA_FIELD / 2))
METRES = [(1.0, 0.4), (1.0, -0.4), (2.5, -0.5), (2.5, 0.5)]


def picture_of(x: float, y: float) -> list[float]:
    """Give where the simulated vehicle's camera, one degree down, sees a place of the floor."""
    ahead, high, down = x - CAMERA_AT[0], CAMERA_AT[2], math.radians(1)
    depth = ahead * math.cos(down) + high * math.sin(down)
    below = high * math.cos(down) - ahead * math.sin(down)
    across = 0.5 - FOCAL * y / depth / WIDTH
    return [round(across, 4), round(0.5 + FOCAL * below / depth / HEIGHT, 4)]


TEXT = f"""\
talaia: 1
site: house
name: House
ros2: {{}}
devices:
  base:
    name: Base
    signals:
      beside: {{name: Beside, unit: m, max_age: 1, source: {{stream: front, sees: lane_offset}}}}
      turned: {{name: Turned, unit: rad, max_age: 1, source: {{stream: front, sees: lane_heading}}}}
      wide: {{name: Lane, unit: m, source: {{stream: front, sees: lane_width}}}}
    streams:
      front:
        name: Front camera
        source: {{topic: /front, type: sensor_msgs/msg/Image}}
        lane:
          floor:
            picture: {[picture_of(*point) for point in METRES]}
            metres: {[list(point) for point in METRES]}
          ahead: [0.9, 2.5]
"""


@pytest.fixture(scope="module")
def camera() -> Iterator[Camera]:
    try:
        camera = Camera(World(0, looks=True))
    except NoRenderer as error:
        missing(str(error))
        raise
    yield camera
    camera.close()


@pytest.mark.parametrize("pose", [(4.6, 0.0, 0.0), (4.6, 0.1, 0.1), (5.2, -0.15, -0.15)])
async def test_a_vehicle_in_the_hall_knows_its_place_in_the_lane(camera, pose) -> None:
    x, beside, yaw = pose
    site = load_site(TEXT)
    assert check_site(site) == []
    numbers = ChannelNumbering(site).numbers_of(site)
    picture = camera.render_view(x, sum(LANE_Y) / 2 + beside, yaw)
    frames = OnePicture(CameraFrame("base/front", 1, 7_000_000, 5_000_000, picture))
    told: asyncio.Future = asyncio.get_running_loop().create_future()
    watch = LaneWatch(
        site=site, numbers=numbers, pictures=frames, clock=HandClock(),
        publish=lambda columns, readings: told.set_result((columns, readings)),
    )  # fmt: skip
    running = asyncio.ensure_future(watch.run())
    columns, readings = await told
    values = dict(zip(columns.channel.tolist(), columns.value.tolist(), strict=True))
    assert values[numbers["base/beside"]] == pytest.approx(beside, abs=0.02)
    assert values[numbers["base/turned"]] == pytest.approx(yaw, abs=0.02)
    assert values[numbers["base/wide"]] == pytest.approx(LANE_Y[1] - LANE_Y[0], abs=0.02)
    assert set(columns.time_us.tolist()) == {7_000_000}
    assert readings["base/beside"].mono_ns == 5_000_000_000
    running.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await running
    assert frames.held == 0


@pytest.mark.parametrize(
    ("old", "new", "where", "problem"),
    [
        ("ahead: [0.9, 2.5]", "ahead: [2.5, 0.9]", "lane.ahead", "expected from where"),
        ("ahead: [0.9, 2.5]", "narrowest: 3", "lane.narrowest", "less than widest"),
        ("ahead: [0.9, 2.5]", "marking: 1", "lane.marking", "how wide a marking is"),
        ("ahead: [0.9, 2.5]", "every: 0", "lane.every", "expected 0.05 to 60 s"),
        ("[1.0, -0.4]", "[1.0, 0.4]", "lane.floor.metres", "lie on one line"),
        ("unit: rad", "unit: deg", "signals.turned.unit", "told in rad"),
        ("max_age: 1", "max_age: 0.1", "signals.beside.source", "old after 0.1 s"),
        ("sees: lane_width", "sees: lane_depth", "signals.wide", "nothing is detected on front"),
    ],
)
def test_a_lane_that_is_described_wrongly_is_told(old, new, where, problem) -> None:
    assert old in TEXT
    found = [str(finding) for finding in check_site(load_site(TEXT.replace(old, new, 1)))]
    assert any(where in text and problem in text for text in found), found


def test_a_signal_of_a_lane_needs_a_camera_that_says_where_it_is() -> None:
    text = TEXT[: TEXT.index("        lane:")]
    found = [str(finding) for finding in check_site(load_site(text))]
    assert any("does not say where the lane is" in problem for problem in found), found
