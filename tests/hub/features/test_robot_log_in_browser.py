"""The page of a robot's log in a real Chromium: found by level, node, words and time; new lines."""

from __future__ import annotations

import os
import re
import time
from pathlib import Path

import pytest
from page_accessibility import find_violations
from playwright.async_api import expect

from talaia.wire.frames import LogLine, RobotLogAck, RobotLogBatch

from ..chromium import sign_in

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]
SCREENS = ((390, "dark"), (1440, "night"), (1440, "light"), (390, "light"))
NODES = ("lidar", "base", "planner_server")
COUNT = 250


def written(at: int, now_us: int) -> LogLine:
    """Give a line of a robot that has talked for a while; the last but ten is an error."""
    grave = at == COUNT - 10
    return LogLine(
        time_us=now_us - (COUNT - at) * 1_000_000,
        level=40 if grave else 30 if at % 2 else 20,
        node="base" if grave else NODES[at % len(NODES)],
        text="left wheel: over-current, switched off" if grave else f"scan {at} came late",
        function="on_scan",
        file="/opt/ros/lib/scan.cpp",
        line=at,
    )


async def keep(gateway, first: int, *lines: LogLine) -> None:
    await gateway.say(RobotLogBatch(boot="run", first=first, lines=list(lines)))
    assert (await gateway.hear(RobotLogAck)).below == first + len(lines)


async def test_a_robots_log_is_found_by_words_level_node_and_time_and_grows_by_itself(
    chromium, hub, gateway
) -> None:
    now_us = time.time_ns() // 1000
    page = await sign_in(chromium, hub, "operator", to="/home")
    await page.goto(f"{hub.origin}/sites/agv/log")
    await expect(page.get_by_text("No line is kept yet")).to_be_visible()
    for first in range(0, COUNT, 125):
        await keep(gateway, first, *(written(first + at, now_us) for at in range(125)))
    # New ones come without a click, and old ones where the list ends.
    lines = page.get_by_role("region", name="Lines").get_by_role("listitem")
    await expect(lines.first).to_contain_text("scan 249 came late")
    await expect(lines.first).to_contain_text("/opt/ros/lib/scan.cpp:249")
    await page.evaluate("scrollTo(0, document.documentElement.scrollHeight)")
    await expect(page.get_by_text("scan 120 came late")).to_be_attached()
    await assert_screens(page)
    await assert_filters(page, lines)
    await assert_new_lines_can_wait(page, gateway, lines, now_us)
    # From a line to the board of its moment, and from the site's own row to the page.
    await lines.first.get_by_role("link", name="Board then").click()
    await page.wait_for_url(re.compile(r"/boards/.*at="))
    row = page.get_by_role("navigation", name="Pages of House vehicle")
    # Until all is there, links give way to what comes, and a press may miss the one it began on.
    await page.goto(f"{hub.origin}/sites/agv/live", wait_until="networkidle")
    await row.get_by_role("link", name="Robot's log").click()
    await page.wait_for_url("**/sites/agv/log")
    assert page.errors == []


async def assert_screens(page) -> None:
    for width, theme in SCREENS:
        await page.set_viewport_size({"width": width, "height": 900})
        await page.evaluate("theme => { document.documentElement.dataset.theme = theme }", theme)
        await page.evaluate("scrollTo(0, 0)")
        if folder := os.environ.get("TALAIA_PICTURES"):
            await page.screenshot(path=Path(folder) / f"log-{width}-{theme}.png")
        assert await find_violations(page) == [], (width, theme)
        assert await page.evaluate("document.documentElement.scrollWidth") <= width, theme
    await page.set_viewport_size({"width": 1440, "height": 900})


async def assert_filters(page, lines) -> None:
    """Each stands in the address, and is there after the page was loaded anew."""
    await page.get_by_label("From level").select_option(label="Error")
    await expect(lines).to_have_count(1)
    await expect(lines.first).to_contain_text("over-current")
    await page.reload()
    await expect(lines).to_have_count(1)
    await page.get_by_role("button", name="Clear").click()
    await page.get_by_label("Node").select_option("lidar")
    await page.get_by_label("Search").fill("SCAN 237 late")
    await expect(lines).to_have_count(1)
    await expect(lines.first).to_contain_text("scan 237 came late")
    await page.get_by_label("Search").fill("never said")
    await expect(page.get_by_text("No line that is kept is like this")).to_be_visible()
    await page.get_by_role("button", name="Show everything").click()
    await page.get_by_label("From (").fill("tomorrow")
    await expect(page.get_by_text("2026-03-29 14:05:09", exact=False).first).to_be_visible()
    await page.get_by_label("From (").fill("")
    # Up to a moment: of later lines none is shown, and none comes.
    moment = await lines.nth(5).locator("t-time").first.evaluate("each => each.us")
    await page.goto(f"{page.url.partition('?')[0]}?to={moment}")
    await expect(lines.first).to_contain_text("scan 244 came late")
    await page.get_by_role("button", name="Clear").click()
    await expect(lines.first).to_contain_text("scan 249 came late")


async def assert_new_lines_can_wait(page, gateway, lines, now_us: int) -> None:
    """What is read stays where it is while the page is told to hold new lines back."""
    hold = page.get_by_role("button", name="New lines come by themselves")
    await hold.click()
    line = LogLine(time_us=now_us + 5_000_000, level=30, node="base", text="one more")
    await keep(gateway, COUNT, line)
    await expect(lines.first).to_contain_text("scan 249 came late")
    await hold.click()
    await expect(lines.first).to_contain_text("one more")
