"""A display in a real Chromium: made by an admin, opened by its address, and nothing of it left."""

from __future__ import annotations

import pytest
from playwright.async_api import expect

from ..chromium import sign_in

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]


async def test_a_display_is_made_opened_and_leaves_its_token_in_no_address(
    chromium, hub, gateway
) -> None:
    page = await sign_in(chromium, hub, "admin", to="/admin/people")
    displays = page.locator("t-displays")
    await displays.get_by_role("button", name="Add a display").click()
    await displays.get_by_label("Name").fill("Hall")
    await displays.get_by_role("checkbox").check()
    await displays.get_by_role("button", name="Make it").click()
    address = await displays.locator("t-copy").evaluate("each => each.text")
    token = address.partition("#")[2]
    assert token.startswith("tal_display_")

    # A browser of its own, in which nobody is signed in.
    screen = await (await chromium.new_context()).new_page()
    asked = []
    screen.on("request", lambda request: asked.append((request.url, request.headers)))
    await screen.goto(address)
    await screen.wait_for_url("**/home")
    await expect(screen.get_by_role("combobox", name="Site")).to_have_value("agv")
    assert not [url for url, headers in asked if token in url or token in str(headers)]
    assert await screen.evaluate("document.cookie") == ""
    # Going back shows no address with it either.
    assert token not in str(await screen.evaluate("[document.referrer, location.href]"))

    await displays.get_by_role("button", name="I have opened it").click()
    await displays.get_by_role("button", name="Revoke the display Hall").click()
    await displays.get_by_role("button", name="Revoke it").click()
    await expect(displays.get_by_text("There are none.")).to_be_visible()
    await screen.goto(f"{hub.origin}/home")
    await screen.wait_for_url("**/login*")
    assert page.errors == []


async def test_who_is_signed_in_is_asked_before_their_browser_becomes_a_display(
    chromium, hub, gateway
) -> None:
    _, token = await hub.hub.people.displays.add_display("Hall", ["agv"])
    page = await sign_in(chromium, hub, "operator", to=f"/display#{token}")
    await expect(page.get_by_role("heading", name="Make this browser a display?")).to_be_visible()
    assert (await (await page.request.get(f"{hub.origin}/api/me")).json())["name"] == "operator"
