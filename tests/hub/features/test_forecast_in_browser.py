"""The forecast of tonight and the week in a real Chromium, and chances while a request is typed."""

from __future__ import annotations

import re
import time
from pathlib import Path

import pytest
from patience import until_answered
from playwright.async_api import expect

from talaia.model.yaml_text.load import dump_site, read_site
from talaia.sim.observatory.night import at_dusk

from ..chromium import sign_in
from .test_night_in_browser import keep

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]

SITE = "observatory"
EXAMPLE = Path(__file__).parents[3] / "examples" / "observatory" / "site.yaml"
AT = f"/api/sites/{SITE}"
DAY_US = 86_400_000_000


def description_where_evening_begins() -> str:
    """The example observatory, moved so that tonight lies ahead whatever time it is.

    The forecast counts from now: near the dawn of the real place nothing is left of tonight.
    """
    return dump_site(at_dusk(read_site(EXAMPLE), time.time()))


def request_at(name: str, dec: float) -> dict[str, object]:
    now_us = time.time_ns() // 1000
    one = {
        "target": {"type": "ICRS", "name": name, "ra": 37.95, "dec": dec},
        "configurations": [{"exposure": 60.0, "count": 10}],
        "windows": [{"start_us": now_us, "end_us": now_us + 20 * DAY_US}],
    }
    return {"proposal": "STARS-1", "name": name, "requests": [one]}


@pytest.fixture
async def observatory(hub):
    """A hub with an observatory, where one waits that can be seen and one that cannot."""
    hub.dome = await hub.gateway(key=await hub.hub.gateways.registry.new_key(SITE))
    await hub.dome.hello(description_where_evening_begins(), site=SITE)
    admin = await hub.client("admin")
    asked = {"id": "STARS-1", "title": "Stars", "hours_allocated": 20.0, "share": 0.5}
    assert (await admin.post(f"{AT}/proposals", json=asked)).status_code == 201
    await admin.put(f"{AT}/proposals/STARS-1/members", json={"name": "operator", "role": "member"})
    operator = await hub.client("operator")
    for name, dec in (("Polaris", 89.26), ("Octans", -89.0)):
        answer = await operator.post(f"{AT}/request-groups", json=request_at(name, dec))
        assert answer.status_code == 201, answer.text

    async def is_planned() -> bool:
        return (await operator.get(f"{AT}/night/week")).status_code != 429

    await until_answered(is_planned)
    return hub


async def test_the_week_is_forecast_with_chances_shares_and_reasons(observatory, chromium):
    page = await sign_in(chromium, observatory, "operator")
    await page.goto(f"{observatory.origin}/sites/{SITE}/night")
    await page.get_by_role("link", name="Forecast", exact=True).first.click()
    forecast = page.locator("t-page-forecast")
    await expect(forecast).to_contain_text("Worked out")
    await expect(forecast).to_contain_text("70 % of the time")
    # Tonight's line has the one that can be seen; the sky is said in words, too.
    await expect(
        forecast.get_by_role("button", name=re.compile("Polaris, proposal A")).first
    ).to_be_visible()
    await expect(forecast.get_by_text("% lit").first).to_be_visible()
    chances = forecast.get_by_role("region", name="Chance of each request")
    await expect(chances.get_by_role("link", name="Polaris")).to_be_visible()
    await expect(chances).to_contain_text("70 %")
    await expect(chances.get_by_role("link", name="Octans")).to_have_count(0)
    waits = forecast.get_by_role("region", name="What waits longer than tonight")
    await expect(waits.get_by_role("link", name="Octans")).to_be_visible()
    await expect(forecast.get_by_role("region", name="Share by proposal")).to_contain_text("20 h")
    # By keyboard to the last night.
    await forecast.locator("summary").last.focus()
    await page.keyboard.press("Enter")
    await expect(forecast.locator("t-plan-timeline")).to_have_count(2)
    await keep(page, "forecast")
    assert page.errors == []


async def test_chances_are_told_while_a_request_is_typed(observatory, chromium):
    page = await sign_in(chromium, observatory, "operator")
    await page.goto(f"{observatory.origin}/sites/{SITE}/requests?new=1")
    form = page.locator("t-request-form")
    await form.locator("[name=target]").fill("The pole")
    await form.locator("[name=ra]").fill("02:31:49")
    await form.locator("[name=dec]").fill("+89:15:51")
    outlook = form.locator("t-request-outlook")
    # Nothing else wants the night, so that only the roof may be against it.
    await expect(outlook).to_contain_text("within 7 nights")
    await expect(outlook).to_contain_text(re.compile(r"Chance: \d+\s% tonight"))
    await form.locator("[name=dec]").fill("-89:15:51")
    await expect(outlook).to_contain_text("never above 30° in its windows")
    await expect(outlook).to_contain_text("Chance: none")
    assert page.errors == []
