"""A page asks for the password anew before it gives rights away, and then goes on."""

from __future__ import annotations

import pytest
from playwright.async_api import expect

from ..chromium import PASSWORD, sign_in
from ..conftest import RunningHub

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]


@pytest.mark.parametrize(
    ("width", "theme"), [(1440, "light"), (390, "dark")], ids=["desktop-light", "phone-dark"]
)
async def test_token_is_made_once_its_person_has_confirmed(
    chromium, settings, history, width: int, theme: str
) -> None:
    async with RunningHub(settings, history) as first:
        await first.populate()
        await (await first.gateway()).hello()
        page = await sign_in(chromium, first, "operator")
        port = first.port
    again = RunningHub(settings, history)
    # The page goes on with the hub that comes back to where it was.
    again.bind_port = port
    async with again as hub:
        await page.set_viewport_size({"width": width, "height": 844})
        await page.emulate_media(color_scheme=theme)
        await page.goto(f"{hub.origin}/account")
        await page.get_by_role("button", name="Make a token").first.click()
        form = page.locator("t-token-form")
        await form.get_by_label("Name").fill("night script")
        await form.get_by_label("Vehicle base").select_option("view")
        await form.get_by_role("button", name="Make the token").click()
        heading = page.get_by_role("heading", name="Confirm that it is you")
        await expect(heading).to_be_visible()
        question = page.locator("t-confirm-person")
        password = question.get_by_label("Your password")
        await expect(password).to_be_focused()
        assert await page.evaluate("document.documentElement.scrollWidth") <= width
        # The wrong one is said where it stands.
        await password.fill("not it at all")
        await password.press("Enter")
        await expect(question.get_by_text("The password is wrong.")).to_be_visible()
        await password.fill(PASSWORD)
        await password.press("Enter")
        await expect(heading).to_be_hidden()
        await expect(page.get_by_text("It is not shown again").first).to_be_visible()
        assert page.errors == []
