"""Pages of each kind in a real Chromium: axe, a phone, the keyboard, the end of a session."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from msgspec.structs import replace
from playwright.async_api import expect

from talaia.model.yaml_text.load import dump_site, read_site

from ..chromium import PASSWORD, sign_in

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]
ROOT = Path(__file__).parents[3]
AXE = ROOT / "web" / "node_modules" / "axe-core" / "axe.min.js"
EXAMPLE = read_site(ROOT / "examples" / "observatory" / "site.yaml")
OBSERVATORY = replace(EXAMPLE, site="agv", interlocks={}, enclosures={}, alarms={}, night=None)
# A page of each kind, and what is on it once it is whole.
PAGES = {
    "/home": "h1",
    "/sites/agv/live": "t-live-tile, h2",
    "/sites/agv/drive": "t-commands h2",
    "/sites/agv/devices/camera": "t-part-camera h2",
    "/sites/agv/history": "t-history-tools",
    "/sites/agv/logbook": "h1",
    "/admin/people": "h1",
    "/nowhere": "h1",
}
RUN = """async () => (await axe.run(document, {resultTypes: ['violations']})).violations.flatMap(
  ({id, nodes}) => nodes.map(({target}) => `${id}: ${target.flat(9).join(' ')}`))"""
WIDTH = "document.documentElement.scrollWidth"


async def test_pages_keep_the_rules_of_axe_fit_a_phone_go_by_keyboard_and_outlive_a_session(
    hub, chromium
) -> None:
    # One session for all of it: a hub and a browser cost more than what is asked of them.
    gateway = await hub.gateway()
    await gateway.hello(description=dump_site(OBSERVATORY))
    page = await sign_in(chromium, hub, "admin")
    await assert_axe_finds_nothing(hub, page)
    await assert_commands_stand_by_device(hub, page)
    await assert_more_pages_are_found_by_keyboard(page)
    await assert_signing_in_leads_back(hub, page)
    assert page.errors == []


async def follow_link(page, path: str) -> None:
    """Go on within the page, as a link does."""
    await page.evaluate(
        "path => { history.pushState(null, '', path);"
        " dispatchEvent(new PopStateEvent('popstate')); }",
        path,
    )


async def assert_axe_finds_nothing(hub, page) -> None:
    """And nothing is wider than a phone; a page of each kind is looked at."""
    if not AXE.is_file():
        pytest.fail("no axe-core in web/node_modules: `make setup` installs it")
    await page.goto(f"{hub.origin}/home")
    await page.evaluate(AXE.read_text())
    broken = {}
    for at, (path, whole) in enumerate(PAGES.items()):
        # Half of them as a phone shows them at night: the rules are of structure and of colours.
        phone = at % 2 == 1
        await page.set_viewport_size({"width": 390 if phone else 1440, "height": 844})
        # As a link does: with the page not loaded anew, neither is axe.
        await follow_link(page, path)
        await page.evaluate(
            "theme => { document.documentElement.dataset.theme = theme; }",
            "dark" if phone else "light",
        )
        await expect(page.locator(f"main > * :is({whole})").first).to_be_visible()
        # A moment later: words that still fade in are of no colour that anybody reads.
        await expect(page.locator("t-loading")).to_have_count(0)
        if found := await page.evaluate(RUN):
            broken[path] = found
        assert await page.evaluate(WIDTH) <= (390 if phone else 1440), path
    assert broken == {}


async def assert_commands_stand_by_device(hub, page) -> None:
    """Of a site where nothing drives: from the left edge on, and nobody is sent to an admin."""
    await page.set_viewport_size({"width": 1440, "height": 844})
    await page.goto(f"{hub.origin}/sites/agv/drive")
    await expect(page.get_by_role("heading", name="Actuate")).to_be_visible()
    cards = page.locator("t-commands t-card")
    box = await cards.first.bounding_box()
    assert box["x"] < 40
    await expect(page.get_by_text("An admin can give you the right")).to_have_count(0)


async def assert_more_pages_are_found_by_keyboard(page) -> None:
    more = page.locator("t-nav.beside").get_by_role("button", name="More")
    await more.focus()
    await page.keyboard.press("Enter")
    for _ in range(2):
        await page.keyboard.press("Tab")
    await expect(page.get_by_role("link", name="Cameras")).to_be_visible()
    await page.keyboard.press("Enter")
    await page.wait_for_url(re.compile("/sites/agv/(logbook|sightings|recordings|cameras)$"))
    await expect(page.locator("t-nav.beside .more")).to_be_hidden()


async def assert_signing_in_leads_back(hub, page) -> None:
    # The hub knows nobody any more while the socket still stands: the next question finds out. It
    # may be one that the page asks by itself, before anybody presses a link.
    await page.context.clear_cookies()
    await follow_link(page, "/sites/agv/history")
    await page.wait_for_url(f"{hub.origin}/login?return=*history*")
    await page.get_by_label("Name").fill("admin")
    await page.get_by_label("Password").fill(PASSWORD)
    await page.keyboard.press("Enter")
    await page.wait_for_url(f"{hub.origin}/sites/agv/history*")
    await expect(page.get_by_role("heading", name="History")).to_be_visible()
