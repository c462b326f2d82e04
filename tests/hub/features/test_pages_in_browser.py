"""Pages of each kind in a real Chromium: axe, a phone, the keyboard, the end of a session."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from msgspec.structs import replace
from page_accessibility import find_violations
from playwright.async_api import TimeoutError as NotYet, expect

from talaia.model.yaml_text.load import dump_site, read_site

from ..chromium import PASSWORD, sign_in

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]
ROOT = Path(__file__).parents[3]
EXAMPLE = read_site(ROOT / "examples" / "observatory" / "site.yaml")
OBSERVATORY = replace(EXAMPLE, site="agv", interlocks={}, enclosures={}, alarms={}, night=None)
# A page of each kind, and what is on it once it is whole.
PAGES = {
    "/home": "h1",
    "/sites/agv/live": "t-live-tile, h2",
    "/sites/agv/drive": "t-command-sections h2",
    "/sites/agv/devices/camera": "t-part-camera h2",
    "/sites/agv/history": "t-history-tools",
    "/sites/agv/logbook": "h1",
    "/admin/people": "h1",
    "/nowhere": "h1",
}
SIGNAL = "weather/wind"
NOW = 1_700_000_000_000_000
COVER = """() => getComputedStyle(document.querySelector('t-app').renderRoot
  .querySelector('t-sign-in-again').renderRoot.querySelector('t-dialog').renderRoot
  .querySelector('dialog'), '::backdrop').backgroundColor"""
GROUND = "getComputedStyle(document.documentElement).backgroundColor"
WIDTH = "document.documentElement.scrollWidth"


async def test_pages_keep_the_rules_of_axe_fit_a_phone_go_by_keyboard_and_outlive_a_session(
    hub, chromium
) -> None:
    # One session for all of it: a hub and a browser cost more than what is asked of them.
    gateway = await hub.gateway()
    await gateway.hello(description=dump_site(OBSERVATORY))
    gateway.channels = {each.address: at for at, each in enumerate(OBSERVATORY.channels())}
    page = await sign_in(chromium, hub, "admin")
    await assert_axe_finds_nothing(hub, page)
    await assert_commands_stand_by_device(hub, page)
    await assert_more_pages_are_found_by_keyboard(page)
    await assert_a_person_signs_in_where_they_are(hub, page, gateway)
    await assert_nobody_else_is_shown_what_was_there(hub, page)
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
    await page.goto(f"{hub.origin}/home")
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
        if found := await find_violations(page):
            broken[path] = found
        # On a busy machine the width of before is still laid out for a moment.
        most = 390 if phone else 1440
        try:
            await page.wait_for_function(f"() => {WIDTH} <= {most}")
        except NotYet:
            pytest.fail(f"{path} is wider than {most} px")
    assert broken == {}


async def assert_commands_stand_by_device(hub, page) -> None:
    """Of a site where nothing drives: in sections that open by the keyboard, and are searched."""
    await page.set_viewport_size({"width": 390, "height": 844})
    await page.goto(f"{hub.origin}/sites/agv/drive")
    await expect(page.get_by_role("heading", name="Actuate")).to_be_visible()
    cards = page.locator("t-command-sections t-card")
    box = await cards.first.bounding_box()
    assert box["x"] < 40
    await expect(page.get_by_text("An admin can give you the right")).to_have_count(0)
    # What stops a device needs no section to be opened.
    telescope = page.get_by_role("region", name="Telescope")
    await expect(telescope.locator("t-card")).to_have_count(0)
    await expect(telescope.get_by_role("button", name="Stop", exact=True)).to_be_visible()
    opens = telescope.get_by_role("button", name="commands")
    await opens.focus()
    await page.keyboard.press("Enter")
    await expect(opens).to_have_attribute("aria-expanded", "true")
    await expect(telescope.get_by_label("Right ascension").first).to_be_visible()
    await page.get_by_role("searchbox", name="Search commands").fill("binning")
    await expect(page.locator("t-command-sections section")).to_have_count(1)
    await expect(page.get_by_role("region", name="camera").locator("t-card")).to_be_visible()
    await page.get_by_role("searchbox").fill("nothing of this")
    await expect(page.get_by_text("Nothing matches.")).to_be_visible()


async def assert_more_pages_are_found_by_keyboard(page) -> None:
    """Of the site's own row; on a phone they are behind *More*."""
    await page.set_viewport_size({"width": 1440, "height": 844})
    row = page.locator("t-nav.site-row")
    await row.get_by_role("link", name="Sightings").focus()
    await page.keyboard.press("Enter")
    await page.wait_for_url(re.compile("/sites/agv/sightings$"))
    await page.set_viewport_size({"width": 390, "height": 844})
    await expect(row).to_be_hidden()
    below = page.locator("t-nav.bottom")
    await below.get_by_role("button", name="More").focus()
    await page.keyboard.press("Enter")
    cameras = below.get_by_role("link", name="Cameras")
    await expect(cameras).to_be_visible()
    await cameras.focus()
    await page.keyboard.press("Enter")
    await page.wait_for_url(re.compile("/sites/agv/cameras$"))
    await expect(page.locator("t-nav.bottom .more")).to_be_hidden()


async def assert_a_person_signs_in_where_they_are(hub, page, gateway) -> None:
    """By keyboard and on a phone; the page stays, and its values go on."""
    await page.set_viewport_size({"width": 390, "height": 844})
    await page.goto(f"{hub.origin}/sites/agv/live")
    await page.evaluate("window.loadedOnce = true")
    await gateway.samples((SIGNAL, NOW, 11.5))
    await expect(page.get_by_text("11.5").first).to_be_visible()
    await end_sessions(hub)
    await expect(page.get_by_label("Password")).to_be_focused()
    # Nothing of the page can be read behind it, and Escape leads nowhere, however often.
    assert await page.evaluate(COVER) == await page.evaluate(GROUND)
    assert await find_violations(page) == []
    assert await page.evaluate(WIDTH) <= 390
    for _ in range(2):
        await page.keyboard.press("Escape")
    await sign_in_again(page)
    await gateway.samples((SIGNAL, NOW + 1, 12.5))
    await expect(page.get_by_text("12.5").first).to_be_visible()

    # The hub knows nobody while the socket still stands: the next question finds out, and is asked
    # once more by itself.
    await page.context.clear_cookies()
    await follow_link(page, "/sites/agv/history")
    await sign_in_again(page)
    await expect(page.locator("t-history-tools")).to_be_visible()
    assert page.url.startswith(f"{hub.origin}/sites/agv/history")
    assert await page.evaluate("window.loadedOnce")


async def assert_nobody_else_is_shown_what_was_there(hub, page) -> None:
    await end_sessions(hub)
    await page.get_by_label("Name").fill("guest")
    await page.get_by_label("Password").fill(PASSWORD)
    async with page.expect_navigation():
        await page.keyboard.press("Enter")
    # Loaded anew: nothing is left of the other's, not even covered.
    await expect(page.get_by_role("button", name="guest: settings")).to_be_visible()
    assert await page.evaluate("window.loadedOnce === undefined")


async def sign_in_again(page) -> None:
    dialog = page.get_by_role("dialog", name="Sign in to go on")
    await expect(dialog).to_be_visible()
    await page.get_by_label("Password").fill(PASSWORD)
    await page.keyboard.press("Enter")
    await expect(dialog).to_be_hidden()


async def end_sessions(hub) -> None:
    """As the same person does in another browser."""
    other = await hub.client("admin")
    assert (await other.delete("/api/me/sessions")).status_code == 204
