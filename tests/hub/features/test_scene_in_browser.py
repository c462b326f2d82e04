"""A robot in space in a real Chromium, judged by where the simulator's own physics has things."""

from __future__ import annotations

import asyncio
import io
import math

import numpy as np
import pytest
from described_robot import found_of, read_robot
from patience import PATIENCE_S, until_answered
from playwright.async_api import expect
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

from talaia.model.discovery.generate_description import propose_description
from talaia.model.yaml_text.write import write_description
from talaia.sim.vehicle.description.floor_map import RESOLUTION
from talaia.sim.vehicle.description.urdf import make_urdf
from talaia.sim.vehicle.world import World
from talaia.wire import frames
from talaia.wire.frames import TapMessage, TapSchema, TapSubscription, TopicEntry, TopicList

from ..chromium import sign_in
from ..conftest import DESCRIPTION

pytestmark = [pytest.mark.browser, pytest.mark.timeout(90)]

GOAL = """    commands:
      goal:
        name: Set goal
        kind: topic
        target: /goal_pose
        type: geometry_msgs/msg/PoseStamped
        role: vehicle.goal
        arguments:
          frame: {type: text, field: header.frame_id}
          x: {type: number, unit: m, field: pose.position.x}
          y: {type: number, unit: m, field: pose.position.y}
          qz: {type: number, field: pose.orientation.z}
          qw: {type: number, field: pose.orientation.w}
"""
SITE = DESCRIPTION.replace("    commands:\n", GOAL, 1)
OPEN = '\ntopics:\n  - {pattern: "/**", right: view}\n'
SHUT = OPEN.replace("view", "admin")
STORE = get_typestore(Stores.LATEST)
TYPES = STORE.types
KINDS = {
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/scan": "sensor_msgs/msg/LaserScan",
    "/robot_description": "std_msgs/msg/String",
    "/map": "nav_msgs/msg/OccupancyGrid",
}
# Heard only once somebody has switched the camera on.
CAMERA = {
    "/front/camera_info": "sensor_msgs/msg/CameraInfo",
    "/front/image_raw/compressed": "sensor_msgs/msg/CompressedImage",
}
TOPICS = KINDS | CAMERA
NUMBERS = {topic: number for number, topic in enumerate(TOPICS, 1)}
# By its columns: where x, y and z of a camera's frame point in that of the base (REP-103).
OPTICAL = Rotation.from_matrix([[0, 0, 1], [-1, 0, 0], [0, -1, 0]])
CAMERA_AT = (0.07, 0.0, 0.37)
WIDTH, HEIGHT, FOCAL = 64, 48, 40.0
# Upper left, upper right, lower left, lower right.
QUARTERS = ((220, 30, 30), (30, 200, 30), (30, 30, 220), (220, 200, 30))
BASE, YAW = (0.6, 0.4), 0.7
PIECE = 60_000
STAMP = (1_780_000_000, 500_000_000)
# So that points are seen whatever of the house lies before them, and counted by their colour.
SCAN_COLOUR = (0xC0, 0x56, 0x1A)


def header(frame: str):
    stamp = TYPES["builtin_interfaces/msg/Time"](*STAMP)
    return TYPES["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)


def transform(parent: str, child: str, at, turn):
    vector = TYPES["geometry_msgs/msg/Vector3"](*at)
    return TYPES["geometry_msgs/msg/TransformStamped"](
        header=header(parent),
        child_frame_id=child,
        transform=TYPES["geometry_msgs/msg/Transform"](
            translation=vector, rotation=TYPES["geometry_msgs/msg/Quaternion"](*turn)
        ),
    )


def camera_messages() -> dict[str, object]:
    """Give a camera's calibration, and a picture with a colour for each quarter."""
    from PIL import Image

    picture = Image.new("RGB", (WIDTH, HEIGHT))
    for at, colour in enumerate(QUARTERS):
        picture.paste(colour, (WIDTH // 2 * (at % 2), HEIGHT // 2 * (at // 2), WIDTH, HEIGHT))
    file = io.BytesIO()
    picture.save(file, "png")
    k = np.array([FOCAL, 0, (WIDTH - 1) / 2, 0, FOCAL, (HEIGHT - 1) / 2, 0, 0, 1])
    info, packed = CAMERA
    return {
        info: TYPES[CAMERA[info]](
            header=header("camera_optical_frame"), height=HEIGHT, width=WIDTH,
            distortion_model="plumb_bob", d=np.zeros(5), k=k, r=np.eye(3).ravel(),
            p=np.zeros(12), binning_x=0, binning_y=0,
            roi=TYPES["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, do_rectify=False),
        ),
        packed: TYPES[CAMERA[packed]](
            header=header("camera_optical_frame"), format="rgb8; png compressed",
            data=np.frombuffer(file.getvalue(), np.uint8),
        ),
    }  # fmt: skip


def house_messages(world: World, ranges) -> dict[str, object]:
    """Give what a robot in this house publishes, as an implementation of others serializes it."""
    tf = TYPES[KINDS["/tf"]]
    turn = Rotation.from_euler("z", YAW).as_quat()
    grid = world.floor_map
    point = TYPES["geometry_msgs/msg/Point"](grid.x, grid.y, 0.0)
    height, width = grid.cells.shape
    origin = TYPES["geometry_msgs/msg/Pose"](
        position=point, orientation=TYPES["geometry_msgs/msg/Quaternion"](0, 0, 0, 1)
    )
    info = TYPES["nav_msgs/msg/MapMetaData"](
        map_load_time=header("").stamp, resolution=RESOLUTION, width=width, height=height,
        origin=origin,
    )  # fmt: skip
    step = math.radians(1)
    return {
        "/tf": tf([transform("odom", "base_link", (*BASE, 0.0), turn)]),
        "/tf_static": tf(
            [
                transform("base_link", "base_scan", (0, 0, 0.19), (0, 0, 0, 1)),
                transform("base_link", "camera_optical_frame", CAMERA_AT, OPTICAL.as_quat()),
            ]
        ),
        **camera_messages(),
        "/scan": TYPES[KINDS["/scan"]](
            header=header("base_scan"), angle_min=0.0, angle_max=359 * step, angle_increment=step,
            time_increment=0.0, scan_time=0.1, range_min=0.12, range_max=8.0, ranges=ranges,
            intensities=np.zeros(0, np.float32),
        ),
        "/robot_description": TYPES[KINDS["/robot_description"]](data=make_urdf()),
        "/map": TYPES[KINDS["/map"]](
            header=header("odom"), info=info, data=grid.cells.reshape(-1)
        ),
    }  # fmt: skip


class HouseRobot:
    """A gateway that answers who takes its topics; what is asked for now is ``asked``."""

    def __init__(self, hub, messages) -> None:  # noqa: D107
        self.hub, self.messages = hub, messages
        self.asked: set[str] = set()
        self.changed = asyncio.Event()
        self.seq = 0

    async def open(self, description: str) -> None:
        self.gateway = await self.hub.gateway()
        await self.gateway.hello(description)
        self.media = await self.hub.camera()
        entries = [
            TopicEntry(number=NUMBERS[topic], topic=topic, type=kind, latched="scan" not in topic)
            for topic, kind in TOPICS.items()
        ]
        await self.media.say(TopicList(topics=entries))
        self.serving = asyncio.create_task(self._serve())

    async def until(self, wanted) -> None:
        """Wait until what is asked for is as wanted."""
        async with asyncio.timeout(PATIENCE_S):
            while not wanted(self.asked):
                self.changed.clear()
                await self.changed.wait()

    async def _serve(self) -> None:
        while True:
            said = await self.gateway.hear(TapSubscription)
            for kind in said.types:
                text, _ = STORE.generate_msgdef(kind)
                await self.media.say(
                    TapSchema(
                        type=kind, encoding="ros2msg", definition=text, message_encoding="cdr"
                    )
                )
            new, self.asked = set(said.topics) - self.asked, set(said.topics)
            self.changed.set()
            for topic in new:
                await self.publish(topic)

    async def publish(self, topic: str) -> None:
        raw = bytes(STORE.serialize_cdr(self.messages[topic], TOPICS[topic]))
        self.seq += 1
        for at in range(0, len(raw), PIECE):
            await self.media.say(
                TapMessage(
                    number=NUMBERS[topic], seq=self.seq, log_us=self.seq * 1000, kept=True,
                    at=at, size=len(raw), data=raw[at : at + PIECE],
                )
            )  # fmt: skip


@pytest.fixture(scope="module")
def house():
    world = World(1)
    world.place_vehicle(*BASE, YAW)
    ranges = world.scan_lidar()
    return world, ranges, house_messages(world, ranges)


# What a topic shows in the scene's element, within whatever shadows that stands.
DRAWN = """((topic) => {
  const look = (root) => {
    const found = root.querySelector('t-scene');
    if (found) return found;
    for (const one of root.querySelectorAll('*')) {
      const inner = one.shadowRoot && look(one.shadowRoot);
      if (inner) return inner;
    }
    return null;
  };
  return look(document)?.drawn(topic) ?? { points: [], px: [], painted: 0 };
})"""
SCENE = f"{DRAWN}('/scan')"


async def shown_scan(page):
    """Wait until a scan is drawn; give its points (m) and where they are on the canvas (px)."""
    await until_answered(lambda: page.evaluate(f"{SCENE}.points.length > 0"))
    found = await page.evaluate(SCENE)
    return np.array(found["points"]), [(place["x"], place["y"]) for place in found["px"]]


def true_points(ranges):
    """Give where the beams ended in the house, by another implementation of turns."""
    known = np.isfinite(ranges)
    angles = np.radians(np.arange(360))[known]
    beams = np.stack(
        [ranges[known] * np.cos(angles), ranges[known] * np.sin(angles), np.zeros(known.sum())], 1
    )
    return Rotation.from_euler("z", YAW).apply(beams) + np.array([*BASE, 0.19])


async def test_the_scan_is_where_the_house_is_and_a_goal_goes_by_the_command_path(
    space, hub, house, tmp_path
) -> None:
    world, ranges, messages = house
    robot = HouseRobot(hub, messages)
    await robot.open(SITE + OPEN)
    page = await sign_in(space, hub, "operator", to="/sites/agv/scene")
    await robot.until(lambda asked: asked == set(KINDS))
    await page.get_by_role("button", name="From above").click()
    # By transforms that come after the scan it is drawn anew.
    await robot.publish("/tf")
    expected = true_points(ranges)
    drawn = f"Math.abs({SCENE}.points[0]?.[0] - {expected[0][0]}) < 0.01"
    await until_answered(lambda: page.evaluate(drawn))
    points, places = await shown_scan(page)
    assert np.abs(points - expected).max() < 0.002
    # What the map has there is solid: the house's own hulls, and no ray of the lidar.
    columns = ((points[:, 0] - world.floor_map.x) / RESOLUTION).astype(int)
    rows = ((points[:, 1] - world.floor_map.y) / RESOLUTION).astype(int)
    near = [
        world.floor_map.cells[row - 1 : row + 2, column - 1 : column + 2].max()
        for row, column in zip(rows, columns, strict=True)
    ]
    assert min(near) == 100
    picture = await page.locator("canvas").screenshot(path=tmp_path / "scene.png")
    assert seen_share(picture, places) > 0.8
    await picture_stands_in_its_frustum(page, robot)
    await page.get_by_role("button", name="From above").click()
    await goal_is_sent(page, robot)
    assert page.errors == []
    # Elsewhere the robot is heard by nobody.
    await page.goto(f"{hub.origin}/home")
    await robot.until(lambda asked: not asked)
    robot.serving.cancel()


def seen_share(picture: bytes, places) -> float:
    """Give the share of places with the scan's colour, of those that are on the picture."""
    from PIL import Image

    pixels = np.asarray(Image.open(io.BytesIO(picture)).convert("RGB")).astype(int)
    height, width, _ = pixels.shape
    inside = [(x, y) for x, y in places if 4 < x < width - 4 and 70 < y < height - 60]
    assert len(inside) > 50
    found = [
        np.abs(pixels[int(y) - 3 : int(y) + 4, int(x) - 3 : int(x) + 4] - SCAN_COLOUR).sum(2).min()
        < 40
        for x, y in inside
    ]
    return sum(found) / len(found)


async def picture_stands_in_its_frustum(page, robot) -> None:
    """Judge where a camera's picture is by another implementation of turns, and by its colours."""
    info = next(iter(CAMERA))
    await page.get_by_role("button", name="In space").click()
    await page.locator(f"[data-topic='{info}']").check()
    await robot.until(lambda asked: asked == set(TOPICS))
    await until_answered(lambda: page.evaluate(f"{DRAWN}('{info}').points.length === 4"))
    found = await page.evaluate(f"{DRAWN}('{info}')")
    corners = np.array(found["points"])
    ahead = 0.6
    x, y = ahead * WIDTH / 2 / FOCAL, ahead * HEIGHT / 2 / FOCAL
    # Upper left and right, lower left and right: x is right, y down, z ahead of the camera.
    seen = np.array([(-x, -y, ahead), (x, -y, ahead), (-x, y, ahead), (x, y, ahead)])
    turn = Rotation.from_euler("z", YAW)
    expected = turn.apply(OPTICAL.apply(seen) + CAMERA_AT) + np.array([*BASE, 0.0])
    assert np.abs(corners - expected).max() < 0.002
    await until_quarters_are(page, info, QUARTERS)


async def until_quarters_are(page, info, quarters) -> None:
    """Wait until the picture in a camera's frustum has these colours, each in its quarter."""
    found = await page.evaluate(f"{DRAWN}('{info}')")
    places = np.array([(place["x"], place["y"]) for place in found["px"]])
    for at, colour in enumerate(quarters):
        right, down = 0.25 + 0.5 * (at % 2), 0.25 + 0.5 * (at // 2)
        shares = np.array([(1 - right) * (1 - down), right * (1 - down), (1 - right) * down])
        place = shares @ places[:3] + right * down * places[3]
        await until_answered(lambda place=place, colour=colour: shows_colour(page, place, colour))


async def shows_colour(page, place, colour) -> bool:
    """Tell whether a place (px) of the scene has a colour: bright, or faded since it is old."""
    from PIL import Image

    picture = Image.open(io.BytesIO(await page.locator("t-scene canvas").screenshot())).convert(
        "RGB"
    )
    pixel = np.array(picture.getpixel((int(place[0]), int(place[1]))), int)
    return (pixel > pixel.min() + 25).tolist() == (np.array(colour) > 100).tolist()


async def goal_is_sent(page, robot) -> None:
    canvas = page.locator("canvas")
    box = await canvas.bounding_box()
    await page.get_by_role("button", name="Set goal").click()
    x, y = box["x"] + box["width"] * 0.6, box["y"] + box["height"] * 0.5
    await page.mouse.move(x, y)
    await page.mouse.down()
    await page.mouse.move(x, y - 80, steps=4)
    await page.mouse.up()
    card = page.locator("t-command-card")
    await expect(card.get_by_role("heading", name="Set goal")).to_be_visible()
    # A place alone asks for nothing.
    assert not [said for said in robot.gateway.heard if isinstance(said, frames.CommandRequest)]
    await card.get_by_role("button", name="Send").click()
    asked = await robot.gateway.hear(frames.CommandRequest)
    assert (asked.device, asked.command, asked.args["frame"]) == ("base", "goal", "odom")
    middle = await page.evaluate(SCENE)
    assert len(middle["points"]) > 0
    assert math.hypot(asked.args["x"], asked.args["y"]) < 10
    turn = 2 * math.atan2(asked.args["qz"], asked.args["qw"])
    # From above, with x of the frame up the screen: it was dragged up.
    assert abs(turn) < 0.2


async def test_who_may_not_follow_topics_is_told_so_and_the_robot_is_not_heard(
    space, hub, house
) -> None:
    robot = HouseRobot(hub, house[2])
    await robot.open(SITE + SHUT)
    page = await sign_in(space, hub, "operator", to="/sites/agv/scene")
    await expect(page.get_by_role("heading", name="Nothing to see in space")).to_be_visible()
    await expect(page.get_by_text("gives you the right")).to_be_visible()
    assert robot.asked == set()
    robot.serving.cancel()


async def test_without_webgl_the_scene_is_seen_from_above_and_says_why(space, hub, house) -> None:
    _, ranges, messages = house
    robot = HouseRobot(hub, messages)
    # As `talaia init` describes a robot with Nav2, with nothing written by hand: its owner has all
    # of its topics.
    found = found_of(read_robot("chosen", "nav2"))
    await robot.open(write_description(propose_description(found, "agv", "Robot", "UTC").site))
    script = """const get = HTMLCanvasElement.prototype.getContext;
      HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
        return kind.startsWith('webgl') ? null : get.call(this, kind, ...more);
      };"""
    page = await sign_in(space, hub, "admin", script=script, to="/sites/agv/scene")
    await robot.until(lambda asked: asked == set(KINDS))
    await expect(page.get_by_text("it has no WebGL")).to_be_visible()

    async def is_placed() -> bool:
        points, _ = await shown_scan(page)
        return bool(np.abs(points - true_points(ranges)).max() < 0.002)

    # Before the robot's frames have come it lies in the scanner's own.
    await until_answered(is_placed)
    robot.serving.cancel()
