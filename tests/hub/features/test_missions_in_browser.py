"""A mission in a real Chromium: written, run, ended by STOP, and put on a schedule."""

from __future__ import annotations

import asyncio
import os
from pathlib import Path

import pytest
from page_accessibility import find_violations
from patience import PATIENCE_S
from playwright.async_api import expect

from talaia.wire import frames
from talaia.wire.browser import PageStop
from talaia.wire.frames import CommandPhase

from ..chromium import sign_in
from ..live.missions.test_missions import LASTING, NOW, answer_command, end_command

pytestmark = [pytest.mark.browser, pytest.mark.timeout(400)]
SCREENS = ((390, "dark"), (1440, "light"))


@pytest.fixture
async def gateway(hub):
    """A robot that was just heard, so that a mission may begin."""
    made = await hub.gateway()
    await made.hello(LASTING)
    await made.samples(("base/speed", NOW, 0.0))
    client = await hub.client("operator")
    async with asyncio.timeout(PATIENCE_S):
        while (site := (await client.get("/api/sites")).json()[0])["stale"] == site["signals"]:
            pass
    return made


async def assert_screens(page, name: str) -> None:
    """Nothing overflows and axe finds nothing, on a phone in the dark and on a desk."""
    for width, theme in SCREENS:
        await page.set_viewport_size({"width": width, "height": 900})
        await page.emulate_media(color_scheme=theme)
        assert await page.evaluate("document.documentElement.scrollWidth") <= width
        assert await find_violations(page) == [], f"{name} at {width}"
        if folder := os.environ.get("TALAIA_PICTURES"):
            picture = Path(folder) / f"{name}-{width}-{theme}.png"
            await page.screenshot(path=picture, full_page=True)


async def write_patrol(page) -> None:
    """Out, a wait, and back: each step as a person enters it."""
    await page.get_by_role("button", name="New mission", exact=True).click()
    form = page.locator("t-mission-form")
    await form.get_by_label("Name", exact=True).first.fill("Patrol")
    for _ in range(2):
        await form.get_by_role("button", name="Add a step").click()
    steps = form.get_by_role("group", name="Step")
    for at in (0, 2):
        command = steps.nth(at).get_by_label("Command", exact=True)
        await command.select_option("base/wander")
    await steps.nth(2).get_by_label("Active").uncheck()
    await steps.nth(1).get_by_label("What", exact=True).select_option("pause")
    await steps.nth(1).get_by_label("Seconds").fill("0.2")
    await assert_screens(page, "missions-form")
    await form.get_by_role("button", name="Save").click()
    await expect(form).to_be_hidden()


def step_line(page, number: int):
    """The line of a step of the run that is shown."""
    steps = page.get_by_role("list", name="Steps").first
    return steps.get_by_role("listitem").nth(number - 1)


async def test_mission_is_written_and_run_with_the_result_of_each_step(
    chromium, hub, gateway
) -> None:
    page = await sign_in(chromium, hub, "operator", to="/sites/agv/missions")
    await write_patrol(page)
    await page.get_by_role("button", name="Start Patrol").click()
    asked = await gateway.hear(frames.CommandRequest)
    assert asked.args == {"active": True}
    # While it goes on, its steps say how they stand, and no second one can begin.
    await expect(step_line(page, 1)).to_contain_text("running")
    await expect(step_line(page, 3)).to_contain_text("not begun")
    await expect(page.get_by_role("button", name="Start Patrol")).to_be_disabled()
    await assert_screens(page, "missions-run")
    await end_command(gateway, asked, CommandPhase.SUCCEEDED, "wandering about")
    await answer_command(gateway, CommandPhase.FAILED, "the wheels do not turn")
    # What became of it is read afterwards, step by step, in the robot's own words.
    ended = page.get_by_role("region", name="Runs", exact=True)
    await ended.get_by_text("Patrol").first.click()
    await expect(step_line(page, 1)).to_contain_text("wandering about")
    await expect(step_line(page, 2)).to_contain_text("succeeded")
    await expect(step_line(page, 3)).to_contain_text("the wheels do not turn")
    await assert_screens(page, "missions-ended")
    assert page.errors == []


async def test_stop_ends_a_mission_on_the_page_and_keeps_the_next_from_beginning(
    chromium, hub, gateway
) -> None:
    page = await sign_in(chromium, hub, "operator", to="/sites/agv/missions")
    await write_patrol(page)
    await page.get_by_role("button", name="Start Patrol").click()
    asked = await gateway.hear(frames.CommandRequest)
    # Another person presses STOP elsewhere.
    await (await hub.page("admin")).say(PageStop(site="agv", device="base", id="s"))
    pressed = await gateway.hear(frames.StopRequest)
    await gateway.say(frames.StopState(device="base", latched=True, who=pressed.who, id="s"))
    assert (await gateway.hear(frames.CommandCancel)).id == asked.id
    await end_command(gateway, asked, CommandPhase.CANCELLED)
    ended = page.get_by_role("region", name="Runs", exact=True)
    await expect(ended).to_contain_text("STOP is latched at Vehicle base, pressed by admin")
    await expect(page.get_by_text("Cannot begin now: STOP is latched")).to_be_visible()
    await expect(page.get_by_role("button", name="Start Patrol")).to_be_disabled()
    assert page.errors == []


async def test_mission_begins_by_itself_at_a_time_of_the_site(chromium, hub, gateway) -> None:
    page = await sign_in(chromium, hub, "operator", to="/sites/agv/missions")
    await write_patrol(page)
    await page.get_by_role("button", name="Change Patrol").click()
    form = page.locator("t-mission-form")
    await form.get_by_label("Begins").select_option("weekly")
    await form.get_by_label("At", exact=True).fill("06:30")
    days = form.get_by_role("group", name="Days; none for every day")
    for day in ("Mon", "Fri"):
        await days.get_by_text(day).click()
    await assert_screens(page, "missions-schedule")
    await form.get_by_role("button", name="Save").click()
    line = page.get_by_role("region", name="Missions", exact=True).get_by_role("listitem")
    await expect(line).to_contain_text("06:30")
    await expect(line).to_contain_text("with the rights of operator; next")
    # It is kept: another page of another person reads the same.
    client = await hub.client("admin")
    (kept,) = (await client.get("/api/sites/agv/missions")).json()["missions"]
    assert kept["mission"]["schedule"] == {"at": "06:30", "days": ["mon", "fri"], "date": ""}
    assert kept["due_us"] > 0
    assert page.errors == []
