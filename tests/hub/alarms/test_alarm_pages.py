"""Alarms in a real Chromium: the bar over the page, acknowledging there, and the logbook."""

from __future__ import annotations

import os
import shutil
import time

import pytest
from playwright.async_api import async_playwright, expect

from talaia.web import static_dir
from talaia.wire.browser import AlarmNews

from ..conftest import DESCRIPTION, PASSWORD  # noqa: TID252 - of the same tests

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

LOW = """
alarms:
  low: {name: Battery low, kind: limit, signal: power/voltage, below: 11, severity: critical,
        max_age: 3600, advice: Bring it home.}
  lost: {name: Speed unknown, kind: expression, expression: "{base/speed} > 99"}
"""


@pytest.fixture
async def chromium():
    program = shutil.which("chromium") or shutil.which("google-chrome")
    missing = "" if program else "Chromium"
    missing = missing or ("" if (static_dir() / "index.html").is_file() else "the built pages")
    if missing:
        (pytest.fail if os.environ.get("TALAIA_REQUIRE_ALL") else pytest.skip)(f"no {missing}")
    clean = {key: value for key, value in os.environ.items() if key != "LD_LIBRARY_PATH"}
    async with async_playwright() as play:
        running = await play.chromium.launch(
            executable_path=program, args=["--no-sandbox", "--disable-gpu"], env=clean
        )
        yield running
        await running.close()


async def sign_in(chromium, hub, name: str):
    page = await chromium.new_page(viewport={"width": 1440, "height": 900})
    page.errors = []
    page.on("pageerror", lambda error: page.errors.append(str(error)))
    await page.goto(f"{hub.origin}/login")
    await page.get_by_label("Name").fill(name)
    await page.get_by_label("Password").fill(PASSWORD)
    await page.get_by_role("button", name="Sign in").click()
    await page.wait_for_url("**/home")
    return page


async def test_bar_shows_an_alarm_on_every_page_until_it_is_acknowledged(hub, chromium):
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + LOW)
    listening = await hub.page("operator")
    page = await sign_in(chromium, hub, "operator")
    bar = page.get_by_role("region", name="Alarms")
    await expect(page.get_by_role("link", name="Alarms")).to_be_visible()
    await expect(bar).to_have_count(0)
    await gateway.samples(("power/voltage", time.time_ns() // 1000, 10.0))
    await expect(bar).to_contain_text("Battery low")
    await expect(bar).to_contain_text("Voltage is 10 V, below 11 V")
    await page.goto(f"{hub.origin}/devices")
    await expect(bar).to_contain_text("Battery low")
    await bar.get_by_role("button", name="Acknowledge Battery low").click()
    await expect(bar).to_have_count(0)
    await listening.hear(AlarmNews, lambda news: news.acked_by == "operator")
    await page.get_by_role("link", name="Alarms").click()
    row = page.locator("li[data-alarm=low]")
    await expect(row).to_contain_text("active, acknowledged")
    await expect(row).to_contain_text("Bring it home.")
    # What cannot be judged is not shown as well.
    await expect(page.locator("li[data-alarm=lost]")).to_contain_text("cannot be judged")
    await row.get_by_role("button", name="What has been").click()
    await expect(row).to_contain_text("acknowledged by operator")
    await page.get_by_role("link", name="Logbook").click()
    await expect(page.get_by_text("Battery low: Voltage is 10 V, below 11 V")).to_be_visible()
    await page.get_by_label("What", exact=True).select_option("Connections")
    await expect(page.get_by_text("gateway connected")).to_be_visible()
    await expect(page.get_by_text("Battery low: Voltage")).to_have_count(0)
    assert page.errors == []


async def test_an_alarm_is_made_in_the_page_after_it_was_tried(hub, chromium):
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION)
    page = await sign_in(chromium, hub, "admin")
    await page.goto(f"{hub.origin}/alarms")
    await page.get_by_role("button", name="New alarm").click()
    await page.get_by_label("Name", exact=True).fill("Too fast")
    await page.get_by_label("Kind").select_option("Expression")
    await page.get_by_label("Condition").fill("{base/sped} > 1")
    await page.get_by_role("button", name="Try it on the last day").click()
    await expect(page.get_by_text("there is no signal 'base/sped'").first).to_be_visible()
    await page.get_by_label("Condition").fill("{base/speed} > 1")
    await page.get_by_role("button", name="Try it on the last day").click()
    await expect(page.get_by_text("it would have been raised 0 times")).to_be_visible()
    await page.get_by_role("button", name="Keep").click()
    await expect(page.locator("li[data-alarm=too_fast]")).to_contain_text("Too fast")
    assert page.errors == []
