"""Interlocks and link-loss policies through the real chain, with a real ROS 2 robot and browser."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator

import pytest
from patience import PATIENCE_MS
from playwright.sync_api import Browser, expect

from talaia.wire import browser
from talaia.wire.frames import CommandPhase

from .conftest import missing
from .pages import picture, visit
from .people import Page, page
from .stack import SITE, Stack, finish, until
from .test_driving import drive, moving, standstill

pytestmark = pytest.mark.robot

DESCRIPTION = """\
talaia: 1
site: faults
name: Slope
ros2: {}
devices:
  base:
    name: Base
    kind: vehicle
    signals:
      tilt:
        name: Tilt
        unit: °
        max_age: 600
        source: {topic: /metric, type: std_msgs/msg/String, name: tilt}
    commands:
      beep: {name: Beep, kind: topic, target: /control, type: std_msgs/msg/String, fixed: {data: b}}
      brake:
        {name: Brake, kind: topic, target: /control, type: std_msgs/msg/String, fixed: {data: h}}
      home: {name: Home, kind: topic, target: /control, type: std_msgs/msg/String, fixed: {data: l}}
    drive: {topic: /cmd_vel, max_speed: 0.5, max_turn: 1.0, max_acceleration: 1000}
    link_loss: {after: 2, run: [{command: base/home}]}
interlocks:
  slope:
    name: Too steep
    when: [{signal: base/tilt, above: 20}]
    refuse: [base/drive, base/beep]
    run: [{command: base/brake}]
    dwell: 2
"""


@pytest.fixture(scope="module")
def slope(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stack]:
    for module in ("rclpy", "mujoco"):
        if not __import__("importlib.util").util.find_spec(module):
            missing(module)
    people = {"driver": "operator", "guest": "guest", "boss": "admin"}
    running = Stack(tmp_path_factory.mktemp("slope"), DESCRIPTION, people)
    try:
        finish(running.ready())
        yield running
    finally:
        running.close()


def tilt(stack: Stack, degrees: float) -> int:
    at = time.monotonic_ns()
    stack.robot.tell(f"metric {{'name': 'tilt', 'magnitude': {degrees}}}")
    return at


async def released(stack: Stack, driver: Page) -> None:
    """Stand level until the interlock lets go."""

    def free() -> bool:
        tilt(stack, 0)
        news = driver.all(browser.InterlockUpdate)
        return bool(news) and not news[-1].locked

    await until(free, what="the interlock released")


async def command(driver: Page, name: str, command_id: str) -> browser.CommandUpdate:
    await driver.say(browser.PageCommand(site=SITE, device="base", command=name, id=command_id))
    return await driver.sees(
        browser.CommandUpdate,
        lambda x: x.id == command_id and x.phase not in {CommandPhase.ACCEPTED, "running"},
    )


async def test_unsafe_stops_the_driver_acts_and_refuses_until_it_was_safe_for_the_dwell_time(
    slope: Stack,
) -> None:
    await slope.fresh()
    async with page(slope, "driver") as driver:
        await released(slope, driver)
        await drive(slope, driver)
        since = len(driver.got)
        at = tilt(slope, 30)
        took_ms = await standstill(slope, at)
        assert took_ms <= 500
        await until(
            lambda: [x for x in slope.heard("/control", at) if x.v == "h"], what="the brake"
        )
        news = await driver.sees(browser.InterlockUpdate, lambda x: x.locked, since=since)
        assert (news.name, news.why) == ("Too steep", "Tilt is above 20 °")
        assert news.refuses == ["Base: driving", "Base: Beep"]
        assert news.longest_s == 0
        refused = await command(driver, "beep", "beep-1")
        assert (refused.phase, refused.message) == ("refused", "Too steep: Tilt is above 20 °")
        await driver.sees(browser.DriveUpdate, lambda x: "Too steep" in x.why)
        # Still pressed when it is level again: nothing moves before the driver has let go.
        level = tilt(slope, 0)
        await driver.sees(
            browser.InterlockUpdate, lambda x: not x.locked, since=len(driver.got), within=10
        )
        assert time.monotonic_ns() - level >= 1_900_000_000
        await until(lambda: time.monotonic_ns() - level > 3_000_000_000, 5)
        assert moving(slope.heard("/cmd_vel", at + 500_000_000)) == []
        await driver.let_go()
        assert (await command(driver, "beep", "beep-2")).phase == "succeeded"
        await driver.free()


async def test_without_a_hub_the_gateway_acts_all_the_same(slope: Stack) -> None:
    await slope.fresh()
    async with page(slope, "driver") as driver:
        await released(slope, driver)
    at = slope.hub.kill()
    await slope.gateway.says("link_loss_acted")
    await until(lambda: [x for x in slope.heard("/control", at) if x.v == "l"], what="home")
    home = next(x for x in slope.heard("/control", at) if x.v == "l")
    assert 1_900_000_000 <= home.t - at <= 4_500_000_000
    at = tilt(slope, 30)
    await until(lambda: [x for x in slope.heard("/control", at) if x.v == "h"], what="the brake")
    await slope.fresh()


@pytest.mark.browser
def test_every_page_shows_the_lock_and_an_admin_overrides_it_with_a_reason(
    slope: Stack, chrome: Browser
) -> None:
    slope.gateway.end()
    slope.start_gateway()
    boss = visit(chrome, slope, "boss", width=1280)
    bar = boss.locator("t-interlock").filter(has_text="Too steep")
    strip = boss.locator("t-interlocks .strip")
    # Nothing was heard of the slope yet: unknown is unsafe.
    expect(bar).to_contain_text("Tilt: no value yet", timeout=PATIENCE_MS)
    while not bar.filter(has_text="above").count():
        # Until the gateway's subscription and the robot have found each other.
        tilt(slope, 30)
        boss.wait_for_timeout(100)
    expect(bar).to_contain_text("Tilt is above 20 °")
    for where in ("home", f"sites/{SITE}/live", f"sites/{SITE}/history", f"sites/{SITE}/drive"):
        boss.goto(f"{slope.address}/{where}")
        expect(bar).to_contain_text("Refused: Base: driving, Base: Beep.")
        # What a page says of it is one line of one height; all of it unfolds when asked for.
        expect(strip).to_contain_text("Tilt is above 20 °")
    picture(boss, "interlock-locked")
    boss.get_by_role("button", name="Show interlocks").click()
    expect(bar).to_be_visible()
    picture(boss, "interlock-unfolded")
    driver = visit(chrome, slope, "driver", width=390)
    seen = driver.locator("t-interlock").filter(has_text="Too steep")
    expect(seen).to_contain_text("Tilt is above 20 °")
    expect(driver.get_by_role("button", name="Override…")).to_have_count(0)
    picture(driver, "interlock-phone")
    place = driver.locator("main").bounding_box()
    boss.get_by_role("button", name="Override…").click()
    boss.get_by_role("button", name="Override", exact=True).click()
    expect(boss.get_by_text("Say why")).to_be_visible()
    boss.get_by_label("Reason").fill("Ramp test, one person beside the robot")
    picture(boss, "interlock-override")
    boss.get_by_role("button", name="Override", exact=True).click()
    for each in (bar, seen):
        expect(each).to_contain_text(re.compile(r"overridden by boss for (10|9) min"))
        expect(each).to_contain_text("Ramp test, one person beside the robot")
    picture(boss, "interlock-overridden")
    boss.get_by_role("button", name="End override").click()
    expect(seen).to_contain_text("Locked since")
    assert driver.locator("main").bounding_box() == place
