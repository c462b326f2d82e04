"""A person sets up a second factor that their role requires, and signs in by it, in Chromium.

The passkey is made and kept by Chromium's own virtual authenticator.
"""

from __future__ import annotations

import pytest
from playwright.async_api import expect
from sqlalchemy import update

from talaia.hub.store.tables import roles

from ..chromium import PASSWORD, sign_in

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]


async def add_authenticator(page, *, verifies: bool) -> None:
    protocol = await page.context.new_cdp_session(page)
    await protocol.send("WebAuthn.enable")
    options = {
        "protocol": "ctap2",
        "transport": "internal",
        "hasResidentKey": True,
        "hasUserVerification": verifies,
        "isUserVerified": verifies,
        "automaticPresenceSimulation": True,
    }
    await protocol.send("WebAuthn.addVirtualAuthenticator", {"options": options})


async def require_factor(hub, role: str) -> None:
    async with hub.hub.core.database.write() as connection:
        await connection.execute(
            update(roles).where(roles.c.name == role).values(factor_required=True)
        )


@pytest.fixture
async def named_hub(hub):
    # Browsers make passkeys for names alone.
    hub.origin = f"http://localhost:{hub.port}"
    await (await hub.gateway()).hello()
    return hub


async def test_passkey_that_a_role_requires_is_made_and_then_signs_in_without_a_password(
    chromium, named_hub
) -> None:
    await require_factor(named_hub, "operator")
    page = await chromium.new_page(viewport={"width": 390, "height": 844})
    page.errors = []
    page.on("pageerror", lambda error: page.errors.append(str(error)))
    await add_authenticator(page, verifies=True)
    await page.goto(f"{named_hub.origin}/login")
    await page.get_by_label("Name").fill("operator")
    await page.get_by_label("Password").fill(PASSWORD)
    await page.get_by_role("button", name="Sign in", exact=True).click()
    # Whatever page is opened, there is nothing else.
    await expect(page.get_by_role("heading", name="Set up a second factor")).to_be_visible()
    await page.goto(f"{named_hub.origin}/sites/agv/live")
    await expect(page.get_by_role("heading", name="Set up a second factor")).to_be_visible()
    assert await page.evaluate("document.documentElement.scrollWidth") <= 390
    await page.get_by_role("button", name="Add a passkey").click()
    await page.get_by_label("Name of the passkey").fill("My phone")
    await page.get_by_role("button", name="Make it").click()
    await expect(page.get_by_text("each of these codes lets you in once")).to_be_visible()
    await page.get_by_role("button", name="I have kept them").click()
    # The page that was asked for.
    await expect(page.get_by_role("heading", name="Set up a second factor")).to_be_hidden()
    assert page.url.endswith("/sites/agv/live")
    await expect(page.locator("t-page-live")).to_be_visible()
    await page.goto(f"{named_hub.origin}/logout")
    await page.get_by_role("button", name="Log out").click()
    await expect(page.get_by_text("You are logged out")).to_be_visible()
    await page.goto(f"{named_hub.origin}/login")
    await page.get_by_role("button", name="Sign in with a passkey").click()
    await page.wait_for_url("**/home")
    await page.goto(f"{named_hub.origin}/account")
    await expect(page.get_by_text("My phone")).to_be_visible()
    await page.get_by_role("button", name="Rename the passkey My phone").click()
    await page.get_by_label("New name of the passkey").fill("Old phone")
    await page.keyboard.press("Enter")
    # The last one stays while the role requires it.
    await page.get_by_role("button", name="Remove the passkey Old phone").click()
    await expect(page.get_by_text("Your role requires a second factor")).to_be_visible()
    assert page.errors == []


async def test_passkey_that_verifies_nobody_is_asked_for_after_the_password_and_confirms_with_it(
    chromium, named_hub
) -> None:
    page = await sign_in(chromium, named_hub, "operator")
    await add_authenticator(page, verifies=False)
    await page.goto(f"{named_hub.origin}/account")
    await page.get_by_role("button", name="Add a passkey").click()
    await page.get_by_role("button", name="Make it").click()
    await page.get_by_role("button", name="I have kept them").click()
    await page.goto(f"{named_hub.origin}/logout")
    await page.get_by_role("button", name="Log out").click()
    await expect(page.get_by_text("You are logged out")).to_be_visible()
    await page.goto(f"{named_hub.origin}/login")
    await page.get_by_label("Name").fill("operator")
    await page.get_by_label("Password").fill(PASSWORD)
    await page.get_by_role("button", name="Sign in", exact=True).click()
    await expect(page.get_by_text("operator has a second factor.")).to_be_visible()
    await page.get_by_role("button", name="Use a passkey instead").click()
    await page.wait_for_url("**/home")
    # As if the sign-in had been long ago.
    named_hub.hub.people.sessions._confirmations._given.clear()
    await page.goto(f"{named_hub.origin}/account")
    await page.get_by_role("button", name="Make a token").first.click()
    form = page.locator("t-token-form")
    await form.get_by_label("Name").fill("night script")
    await form.get_by_label("Vehicle base").select_option("view")
    await form.get_by_role("button", name="Make the token").click()
    question = page.locator("t-confirm-person")
    password = question.get_by_label("Your password")
    # Without the password such a key alone does not do.
    await question.get_by_role("button", name="Use a passkey").click()
    await expect(question.get_by_text("The password is wrong.")).to_be_visible()
    await password.fill(PASSWORD)
    await question.get_by_role("button", name="Use a passkey").click()
    await expect(page.get_by_text("It is not shown again").first).to_be_visible()
    assert page.errors == []
