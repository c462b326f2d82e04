"""A person signs in by a real provider that we did not write, in Chromium."""

from __future__ import annotations

import dataclasses
import json
from urllib.parse import parse_qs, urlsplit

import pytest
from patience import PATIENCE_MS
from playwright.async_api import expect

from ..conftest import RunningHub
from ..glewlwyd import CLIENT, PASSWORD, SECRET, run_glewlwyd

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]


async def give_password(page, provider) -> None:
    """Do what the provider's own form does; its scripts come with packages that are not here."""
    await page.wait_for_url("**/login.html?*")
    asked = {name: said[0] for name, said in parse_qs(urlsplit(page.url).query).items()}
    given = {"username": "ada", "password": PASSWORD}
    answer = await page.context.request.post(f"{provider.origin}/api/auth", data=given)
    assert answer.ok
    await page.goto(f"{asked['callback_url']}&g_continue")


async def test_person_of_a_real_provider_signs_in_and_one_that_does_not_say_when_confirms_nothing(
    chromium, settings, history, tmp_path
) -> None:
    async with run_glewlwyd(tmp_path) as provider:
        (tmp_path / "secret").write_text(SECRET)
        asked = {
            "issuer": provider.issuer,
            "client_id": CLIENT,
            "client_secret_file": "secret",
            "label": "Glewlwyd",
            "scopes": [],
            "groups": {"chiefs": "admin"},
            "domains": ["uni.example"],
            "new_people": True,
        }
        (tmp_path / "oidc.yaml").write_text(json.dumps(asked))
        settings = dataclasses.replace(settings, oidc=tmp_path / "oidc.yaml")
        async with RunningHub(settings, history) as hub:
            await hub.populate()
            await (await hub.gateway()).hello()
            await provider.set_up(f"{hub.origin}/oidc")
            page = await chromium.new_page(viewport={"width": 1280, "height": 900})
            page.set_default_timeout(PATIENCE_MS)
            await page.goto(f"{hub.origin}/login?return=/admin/roles")
            await page.get_by_role("button", name="Sign in with Glewlwyd").click()
            await give_password(page, provider)
            await page.wait_for_url(f"{hub.origin}/admin/roles")
            await expect(page.get_by_role("checkbox", name="guest", exact=True)).to_be_visible()
            # As if the sign-in had been long ago.
            hub.hub.people.sessions._confirmations._given.clear()
            await page.get_by_role("checkbox", name="guest", exact=True).click()
            await page.get_by_role("button", name="Sign in anew").click()
            # Although she is signed in there.
            await give_password(page, provider)
            # It asks for the password and then says of the time only that it is 0 (Glewlwyd 2.7.5).
            await expect(
                page.get_by_text("does not say when you gave your password")
            ).to_be_visible()
            assert not any(each["factor_required"] for each in await _roles(hub))
            await page.goto(f"{hub.origin}/account")
            await expect(page.get_by_text("have no password here")).to_be_visible()


async def _roles(hub) -> list[dict]:
    return (await (await hub.client("admin")).get("/api/roles")).json()["roles"]
