"""The fleet's page in a real Chromium: STOP for a group, and a command with what became of it."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from page_accessibility import find_violations
from playwright.async_api import expect

from talaia.wire import frames
from talaia.wire.frames import CommandPhase

from ..chromium import sign_in
from ..live.missions.test_missions import LASTING, NOW, end_command

pytestmark = [pytest.mark.browser, pytest.mark.timeout(400)]
# Sockets of the page can be cut, and no other is opened then.
CUT = """const Socket = WebSocket; window.sockets = []; window.cut = false;
window.WebSocket = class extends Socket {
  constructor(url, ...more) {
    super(cut ? `${url}/nowhere` : url, ...more);
    sockets.push(this);
  }
};"""
SCREENS = ((390, "dark"), (1440, "light"))
# One more below the example's `interlocks`, which end it.
LOCK = """
  crowd:
    name: People in the hall
    when: [{signal: base/speed, above: 99}]
    refuse: [base/wander]
"""


@pytest.fixture
async def fleet(hub):
    """Three robots of one kind; the third is kept from wandering by an interlock."""
    robots = {}
    for number, name in enumerate(("Anna", "Bruno", "Clara")):
        site = "agv" if number == 0 else f"agv{number}"
        key = await hub.hub.gateways.registry.new_key(site) if number else ""
        robots[name] = await hub.gateway(key=key)
        text = LASTING.replace("name: House vehicle", f"name: {name}", 1)
        text = text.replace("site: agv\n", f"site: {site}\n", 1) + LOCK
        await robots[name].hello(text, site=site)
        await robots[name].samples(("base/speed", NOW, 0.0))
        why = "Ultrasonic sees somebody" if name == "Clara" else ""
        lock = frames.InterlockState(interlock="crowd", locked=bool(why), unsafe=bool(why), why=why)
        await robots[name].say(lock)
    return robots


async def assert_screens(page, name: str) -> None:
    """Nothing overflows and axe finds nothing, on a phone in the dark and on a desk."""
    for width, theme in SCREENS:
        await page.set_viewport_size({"width": width, "height": 900})
        await page.emulate_media(color_scheme=theme)
        assert await page.evaluate("document.documentElement.scrollWidth") <= width
        assert await find_violations(page) == [], f"{name} at {width}"
        if folder := os.environ.get("TALAIA_PICTURES"):
            picture = Path(folder) / f"{name}-{width}-{theme}.png"
            await page.evaluate("scrollTo(0, 0)")
            await page.screenshot(path=picture, full_page=True)


async def test_home_shows_few_sites_with_a_live_picture_and_calls_none_online_without_the_hub(
    chromium, hub, fleet
) -> None:
    page = await sign_in(chromium, hub, "operator", script=CUT)
    cards = page.locator("t-site-card")
    await expect(cards).to_have_count(3)
    for name in fleet:
        card = cards.filter(has_text=name)
        await expect(card.locator("t-thumbnail")).to_contain_text("Waiting for a picture")
    await assert_screens(page, "home-few")
    online = cards.get_by_text("online", exact=True)
    await expect(online).to_have_count(3)
    # The hub is out of reach: who stands how is known to nobody, and no time goes on.
    await page.evaluate("cut = true; for (const socket of sockets) socket.close();")
    await expect(page.get_by_text("No connection to the hub")).to_be_visible()
    await expect(cards.get_by_text("unknown", exact=True)).to_have_count(3)
    await expect(page.get_by_text("online")).to_have_count(0)
    await page.evaluate("cut = false")
    await expect(online).to_have_count(3)
    assert page.errors == []


async def test_stop_for_the_chosen_stops_these_and_no_other_and_says_how_far_it_got(
    chromium, hub, fleet
) -> None:
    page = await sign_in(chromium, hub, "operator", to="/fleet")
    for name in ("Anna", "Bruno"):
        await page.get_by_role("checkbox", name=name).check()
    await page.get_by_role("button", name="STOP").click()
    pressed = {name: await fleet[name].hear(frames.StopRequest) for name in ("Anna", "Bruno")}
    assert {stop.who for stop in pressed.values()} == {"operator"}
    # One is known to stand still; of the other nobody knows yet, and the page says just that.
    stop = {"device": "base", "latched": True, "who": "operator"}
    anna, bruno = pressed["Anna"].id, pressed["Bruno"].id
    await fleet["Anna"].say(frames.StopState(**stop, confirmed=True, id=anna))
    await fleet["Bruno"].say(frames.StopState(**stop, id=bruno))
    lines = page.get_by_role("list", name="How far STOP got").get_by_role("listitem")
    await expect(lines.filter(has_text="Anna")).to_contain_text("stands still")
    await expect(lines.filter(has_text="Bruno")).to_contain_text("has not confirmed")
    await expect(page.get_by_text("1 of 2 stopped, 1 latched")).to_be_visible()
    assert not [one for one in fleet["Clara"].heard if isinstance(one, frames.StopRequest)]
    await assert_screens(page, "fleet-stop")
    # Escape is STOP, wherever the focus is; with none chosen it is for all.
    await page.get_by_role("button", name="Choose none").click()
    await page.keyboard.press("Escape")
    await fleet["Clara"].hear(frames.StopRequest)
    assert page.errors == []


async def test_command_to_a_group_says_who_will_do_it_and_what_became_of_it_at_each(
    chromium, hub, fleet
) -> None:
    page = await sign_in(chromium, hub, "operator", to="/fleet")
    await page.get_by_role("button", name="Choose all 3").click()
    command = page.get_by_role("region", name="Command", exact=True)
    label = "Vehicle base: Wander about (3 of 3)"
    await command.get_by_role("combobox").select_option(label=label)
    members = command.get_by_role("list", name="Who will do it").get_by_role("listitem")
    await expect(members.filter(has_text="Anna")).to_contain_text("is asked")
    await expect(members.filter(has_text="Clara")).to_contain_text("Ultrasonic sees somebody")
    await expect(command.get_by_text("2 of 3", exact=True)).to_be_visible()
    await assert_screens(page, "fleet-preview")
    # What is about to happen is said by name, and nothing is sent before the answer.
    await command.get_by_role("button", name="Send…").click()
    await expect(page.get_by_text("To 2 of 3: Anna, Bruno.").last).to_be_visible()
    await page.get_by_role("button", name="Send", exact=True).click()
    asked = {name: await fleet[name].hear(frames.CommandRequest) for name in ("Anna", "Bruno")}
    group = {one.id.rpartition(".")[0] for one in asked.values()}
    assert len(group) == 1
    await end_command(fleet["Anna"], asked["Anna"], CommandPhase.SUCCEEDED, "wandering")
    await end_command(fleet["Bruno"], asked["Bruno"], CommandPhase.REFUSED, "Rain locks it")
    results = command.get_by_role("list", name="What became of it").get_by_role("listitem")
    await expect(results.filter(has_text="Anna")).to_contain_text("wandering")
    await expect(results.filter(has_text="Bruno")).to_contain_text("Rain locks it")
    await expect(command.get_by_text("2 of 2 ended, 1 succeeded")).to_be_visible()
    await assert_screens(page, "fleet-results")
    # Its lines go by names also when others are chosen by then.
    await page.get_by_role("button", name="Choose none").click()
    await expect(results.filter(has_text="Anna")).to_contain_text("wandering")
    assert not [one for one in fleet["Clara"].heard if isinstance(one, frames.CommandRequest)]
    assert page.errors == []
