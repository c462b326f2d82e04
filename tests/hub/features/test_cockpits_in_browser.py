"""The cockpits of vehicle, arm and observatory in a real Chromium: axe, a thumb, a gamepad."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest
from page_accessibility import find_violations
from playwright.async_api import expect

from talaia.wire.frames import CommandRequest, StopRequest

from ..chromium import sign_in

pytestmark = [pytest.mark.browser, pytest.mark.timeout(400)]
ROOT = Path(__file__).parents[3]
WIDTH = "document.documentElement.scrollWidth"
SCREENS = ((390, "light"), (820, "dark"), (1440, "night"), (2560, "light"))
OBSERVATORY = (ROOT / "examples" / "observatory" / "site.yaml").read_text()
PARTS = ("Weather", "Dome", "Sky now", "Target", "Camera")
THEME = "document.documentElement.dataset.theme ?? ''"
JOINTS = ("pan", "lift", "elbow")
PAD = """
window.pad = {index: 0, id: "a pad", mapping: "standard", connected: true, timestamp: 0,
  axes: [0, 0, 0, 0], buttons: Array.from({length: 17}, () => ({pressed: false, value: 0}))};
navigator.getGamepads = () => [window.pad];
window.shaken = [];
Object.defineProperty(navigator, "vibrate", {value: (rhythm) => window.shaken.push(rhythm) > 0});
"""
PRESS = "pad.buttons[1] = {pressed: true, value: 1}"


def arm_description() -> str:
    """Describe an arm as `talaia init` does: no kind, no roles, ends of joints, a jog, poses."""
    joints = "".join(
        f"      {joint}: {{name: {joint.title()}, unit: rad, minimum: -3.0, maximum: 3.0,"
        f" decimals: 2, max_age: 600, source: {{topic: /joint_states,"
        f' type: sensor_msgs/msg/JointState, field: "position[{at}]"}}}}\n'
        for at, joint in enumerate(JOINTS)
    )
    axes = "".join(
        f"          {axis}: {{type: number, field: twist.{axis.replace('_', '.')}, unit: m/s,"
        f" minimum: -0.05, maximum: 0.05, default: 0.0}}\n"
        for axis in ("linear_x", "linear_z")
    )
    return f"""talaia: 1
site: agv
name: Arm on the bench
ros2: {{}}
devices:
  arm:
    name: Arm
    signals:
{joints}    commands:
      jog:
        name: Jog
        kind: topic
        target: /servo_node/delta_twist_cmds
        type: geometry_msgs/msg/TwistStamped
        fixed: {{header.frame_id: base_link}}
        arguments:
{axes}      to_home:
        name: Move arm to home
        kind: service
        target: /home
        type: std_srvs/srv/Trigger
        confirm: true
"""


async def keep_picture(page, name: str) -> None:
    """Keep what is on the screen, where a person asked for it."""
    if folder := os.environ.get("TALAIA_PICTURES"):
        await page.screenshot(path=Path(folder) / f"{name}.png")


async def assert_screens(page, name: str) -> None:
    """Nothing is wider than its screen, and axe finds nothing, from a phone to a wall."""
    for width, theme in SCREENS:
        await page.set_viewport_size({"width": width, "height": 900})
        await page.evaluate("theme => { document.documentElement.dataset.theme = theme }", theme)
        await expect(page.locator("t-loading")).to_have_count(0)
        await keep_picture(page, f"cockpit-{name}-{width}-{theme}")
        assert await find_violations(page) == [], (width, theme)
        assert await page.evaluate(WIDTH) <= width, theme


async def test_an_arm_has_its_joints_between_their_ends_steps_of_its_tool_and_poses(
    hub, chromium
) -> None:
    gateway = await hub.gateway()
    await gateway.hello(arm_description())
    gateway.channels = {f"arm/{joint}": at for at, joint in enumerate(JOINTS)}
    page = await sign_in(chromium, hub, "operator", to="/sites/agv/drive")
    now = time.time_ns() // 1000
    for joint, at in zip(JOINTS, (0.5, 2.95, -1.0), strict=True):
        await gateway.samples((f"arm/{joint}", now, at))
    near = page.get_by_role("meter", name="Lift")
    await expect(near).to_have_attribute("aria-valuetext", "2.95\u202frad, near its end")
    await assert_screens(page, "arm")
    await page.set_viewport_size({"width": 1440, "height": 900})
    await page.get_by_role("button", name="Move −z").click()
    step = (await gateway.hear(CommandRequest)).args
    # The smallest step, and no other axis moves.
    assert step["linear_z"] == pytest.approx(-0.005)
    assert step["linear_x"] == 0
    await page.get_by_role("button", name="Move arm to home…").click()
    await page.get_by_role("button", name="Move arm to home", exact=True).click()
    assert (await gateway.hear(CommandRequest)).command == "to_home"
    assert page.errors == []


async def test_a_vehicles_cockpit_fits_each_screen_and_one_thumb_and_a_gamepad_stops_it(
    hub, chromium
) -> None:
    gateway = await hub.gateway()
    await gateway.hello()
    page = await sign_in(chromium, hub, "operator", script=PAD, to="/sites/agv/drive")
    await expect(page.locator("t-drive-hud")).to_contain_text("Speed")
    await assert_screens(page, "vehicle")
    await assert_one_thumb_reaches_all(page)
    await page.bring_to_front()
    await page.evaluate(PRESS)
    assert (await gateway.hear(StopRequest)).who == "operator"
    assert [300, 80, 300] in await page.evaluate("shaken")
    # Every page of the site is in its own row, and its name is read in full.
    await page.set_viewport_size({"width": 1440, "height": 900})
    row = page.get_by_role("navigation", name="Pages of House vehicle")
    for name in ("Logbook", "Sightings", "Recordings", "Cameras"):
        await expect(row.get_by_role("link", name=name)).to_be_visible()
    select = page.get_by_label("Site", exact=True)
    assert await select.evaluate("each => each.scrollWidth <= each.clientWidth")
    assert page.errors == []


async def assert_one_thumb_reaches_all(page) -> None:
    """STOP, pad and speed stand on a phone's one screen, the pad at the side of the thumb."""
    await page.set_viewport_size({"width": 390, "height": 844})
    thumb = page.get_by_role("group", name="Thumb that drives")
    for side in ("Right", "Left"):
        await thumb.get_by_text(side).click()
        await page.evaluate("scrollTo(0, 0)")
        pad = await page.locator("t-pad").bounding_box()
        middle = pad["x"] + pad["width"] / 2
        assert (middle > 195) == (side == "Right")
        await expect(page.locator("t-arrows")).to_be_hidden()
        # Above the places at the lower edge.
        assert pad["y"] + pad["height"] <= 844 - 56
    await thumb.get_by_text("Both").click()
    await expect(page.locator("t-arrows")).to_be_visible()


async def test_an_observatorys_night_stands_on_one_screen_and_turns_red(hub, chromium) -> None:
    key = await hub.hub.gateways.registry.new_key("observatory")
    gateway = await hub.gateway(key=key)
    await gateway.hello(OBSERVATORY, site="observatory")
    page = await sign_in(chromium, hub, "operator", to="/sites/observatory/night")
    for part in PARTS:
        await expect(page.get_by_role("region", name=part, exact=True)).to_be_visible()
    await expect(page.get_by_role("heading", name="Log", exact=True)).to_be_visible()
    await assert_screens(page, "night")
    await page.get_by_role("button", name="Red screen").click()
    assert await page.evaluate(THEME) == "night"
    await page.get_by_role("button", name="Leave red").click()
    assert await page.evaluate(THEME) != "night"
    assert page.errors == []
