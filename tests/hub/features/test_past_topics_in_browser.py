"""A board in the past in a real Chromium: its scene, messages and log are those of a recording."""

from __future__ import annotations

import os

import pytest
from patience import until_answered
from playwright.async_api import expect
from rosbags.rosbag2 import StoragePlugin, Writer

from talaia.sim.vehicle.world import World

from ..chromium import sign_in
from ..conftest import DESCRIPTION
from .test_recorded_topics import BEGIN_US, ODOM, SECOND_US, odometry
from .test_recordings import files
from .test_scene_in_browser import BASE, KINDS, SCENE, STORE, YAW, house_messages

pytestmark = [pytest.mark.browser, pytest.mark.timeout(600)]
RULES = '\nrecording: {}\ntopics:\n  - {pattern: "/**", right: view}\n'
LOG = "rcl_interfaces/msg/Log"
LENGTH_S = 40
# Where pictures of the board go, for who looks at them; none are taken without it.
PICTURES = os.environ.get("TALAIA_PICTURES", "")


def log_line(second: int) -> bytes:
    made = STORE.types[LOG](
        stamp=STORE.types["builtin_interfaces/msg/Time"](sec=second, nanosec=0),
        level=40 if second == 12 else 20,
        name="planner",
        msg=f"second {second}",
        file="",
        function="",
        line=0,
    )
    return bytes(STORE.serialize_cdr(made, LOG))


def drive(tmp_path) -> bytes:
    """Record a drive of 40 s in the house as rosbags does: another's writer."""
    world = World(1)
    world.place_vehicle(*BASE, YAW)
    house = house_messages(world, world.scan_lidar())
    folder = tmp_path / "drive"
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        kinds = {**KINDS, "/odom": ODOM, "/rosout": LOG}
        of = {name: bag.add_connection(name, kind, typestore=STORE) for name, kind in kinds.items()}

        def write(topic, at_us, data) -> None:
            bag.write(of[topic], (BEGIN_US + at_us) * 1000, data)

        for topic in ("/tf_static", "/robot_description", "/map"):
            data = STORE.serialize_cdr(house[topic], KINDS[topic])
            write(topic, 0, bytes(data))
        for n in range(5 * LENGTH_S):
            write("/odom", n * 200_000, odometry(n / 5))
            for topic in ("/tf", "/scan"):
                write(topic, n * 200_000, bytes(STORE.serialize_cdr(house[topic], KINDS[topic])))
            if n % 5 == 0:
                write("/rosout", n * 200_000, log_line(n // 5))
    return next(folder.glob("*.mcap")).read_bytes()


async def picture(page, name: str) -> None:
    """Have the board drawn at both widths, in both themes, for who looks at it."""
    if not PICTURES:
        return
    for width in (1440, 390):
        await page.set_viewport_size({"width": width, "height": 1000})
        for theme in ("light", "dark"):
            await page.evaluate("t => (document.documentElement.dataset.theme = t)", theme)
            await page.screenshot(path=f"{PICTURES}/{name}-{width}-{theme}.png", full_page=True)
    await page.set_viewport_size({"width": 1280, "height": 800})


async def test_scene_messages_and_log_are_those_of_the_moment(chromium, hub, tmp_path) -> None:
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + RULES)
    done = await (await files(hub)).bring(
        drive(tmp_path), begin_us=BEGIN_US, end_us=BEGIN_US + LENGTH_S * SECOND_US
    )
    assert done.done
    operator = await hub.client("operator")
    tiles = [
        ("scene", {}),
        ("topic", {"topic": "/odom", "fields": ["pose.pose.position.x"]}),
        ("log", {}),
    ]
    board = {
        "name": "Past",
        "note": "",
        "site": "agv",
        "kind": "",
        "device": "",
        "tiles": [
            {
                "id": f"t{n}",
                "type": kind,
                "title": "",
                "settings": settings,
                "desktop": None,
                "phone": None,
            }
            for n, (kind, settings) in enumerate(tiles)
        ],
    }
    key = (await operator.post("/api/boards", json={"board": board})).json()["key"]
    page = await sign_in(chromium, hub, "operator")
    # 20 s after its begin.
    await page.goto(f"{hub.origin}/boards/{key}?at=2026-01-01T12:00:20Z")
    plot = page.locator("t-field-plot")
    await expect(plot).to_contain_text("position.x 20.0")
    scene = page.locator("t-scene")
    await until_answered(
        lambda: page.evaluate(f"{SCENE}.points.length > 50 && {SCENE}.painted > 0")
    )
    log = page.locator("t-tile-log")
    await expect(log.locator("li").first).to_contain_text("second 20")
    await picture(page, "within")

    # A second later by a key, and played on.
    slider = page.locator("t-time-bar").get_by_role("slider", name="Moment")
    await slider.press("ArrowRight")
    await expect(plot).to_contain_text("position.x 21.0")
    await expect(log.locator("li").first).to_contain_text("second 21")
    bar = page.locator("t-time-bar")
    await bar.get_by_label("Speed").select_option("10")
    await bar.get_by_role("button", name="Play").click()
    await expect(log.locator("li").first).to_contain_text("second 3")
    await bar.get_by_role("button", name="Pause").click()

    # Beyond the recording: said, with a way back into it.
    await page.goto(f"{hub.origin}/boards/{key}?at=2026-01-01T12:05:00Z")
    topic = page.locator("t-tile-topic")
    await expect(topic).to_contain_text("Nothing was recorded at this moment")
    await expect(scene).to_contain_text("Nothing was recorded at this moment")
    await picture(page, "beyond")
    await topic.get_by_role("button", name="Before, until").click()
    await expect(plot).to_contain_text("position.x 39.8")
    assert page.errors == []
