"""The form of requests in a real Chromium: all that can be asked is written, kept and read back."""

from __future__ import annotations

import datetime as dt
import time
from pathlib import Path

import pytest
from playwright.async_api import expect

from ..chromium import sign_in
from .test_night_in_browser import keep

pytestmark = [pytest.mark.browser, pytest.mark.timeout(180)]

SITE = "observatory"
DESCRIPTION = (Path(__file__).parents[3] / "examples" / "observatory" / "site.yaml").read_text()
AT = f"/api/sites/{SITE}"
PROPOSAL = {"id": "STARS-1", "title": "Stars", "hours_allocated": 200.0, "share": 0.5}
MINUTE_US = 60_000_000
# What a person writes; the rest of a request follows from it.
ASKED = ("target", "configurations", "constraints", "windows")


@pytest.fixture
async def observatory(hub):
    """A hub with an observatory, and a proposal of which the operator is a member."""
    hub.dome = await hub.gateway(key=await hub.hub.gateways.registry.new_key(SITE))
    await hub.dome.hello(DESCRIPTION, site=SITE)
    admin = await hub.client("admin")
    assert (await admin.post(f"{AT}/proposals", json=PROPOSAL)).status_code == 201
    await admin.put(f"{AT}/proposals/STARS-1/members", json={"name": "operator", "role": "member"})
    return hub


async def group_of(hub, number: str) -> dict:
    """Give the group of a request, as it is kept."""
    client = await hub.client("operator")
    return (await client.get(f"{AT}/requests/{number}")).json()["group"]


def asks(group: dict) -> list:
    """Give what a group asks, places to a thousandth of a second of arc."""
    said = [group["operator"], group["name"], group["priority"]]
    for one in group["requests"]:
        target = dict(one["target"] or {})
        for name in ("ra", "dec"):
            if name in target:
                target[name] = pytest.approx(target[name], abs=3e-7)
        said.append({name: one[name] for name in ASKED} | {"target": target})
    return said


async def write_star(form) -> None:
    """Write one request with all that is rare."""
    await form.locator("[name=name]").fill("Rapid stars")
    await form.locator("[name=target]").fill("Barnard's star")
    await form.locator("[name=ra]").fill("17:57:48.5")
    await form.locator("[name=dec]").fill("+04:41:36")
    await form.get_by_text("It moves among the stars").click()
    await form.get_by_label("Proper motion in RA").fill("-801.551")
    await form.get_by_label("Proper motion in dec").fill("10362.394")
    await form.get_by_label("Epoch of the coordinates").fill("2016")
    # Only what the site has can be chosen.
    options = await form.locator("[name=filter-0] option").all_text_contents()
    assert options == ["any", "L", "R", "G", "B", "Ha"]
    await form.locator("[name=filter-0]").select_option("Ha")
    await form.get_by_label("Gain").fill("1000000")
    await expect(form.get_by_text("Gain: expected")).to_be_visible()
    await form.get_by_label("Gain").fill("120")
    await form.get_by_text("Only in a part of a period").click()
    await form.get_by_label("Period (days)").fill("0.56738")
    await expect(form.get_by_text("Write JD 2460000.5")).to_be_visible()
    await form.get_by_label("Phase 0 at (UTC)").fill("JD 2460000.1234")
    await form.get_by_label("From phase").fill("0.9")
    await form.get_by_label("To phase").fill("0.2")


async def write_darks(form) -> None:
    """Add a second request: frames that need no sky."""
    await form.get_by_role("button", name="Add a request").click()
    await form.locator("[name=way]").select_option("none")
    await expect(form.get_by_text("Light frames need a target")).to_be_visible()
    await form.locator("[name=type-0]").select_option("DARK")
    await expect(form.get_by_text("Light frames need a target")).to_have_count(0)
    await form.get_by_role("button", name="Add frames").click()
    await expect(form.locator("[name=type-1]")).to_be_focused()
    await form.locator("[name=type-1]").select_option("BIAS")
    await expect(form.locator("[name=exposure-1]")).to_have_value("0")


async def test_a_group_is_written_kept_and_opened_with_all_of_it(observatory, chromium):
    hub = observatory
    page = await sign_in(chromium, hub, "operator", to=f"/sites/{SITE}/requests?new=1")
    form = page.locator("t-request-form")
    await write_star(form)
    await form.get_by_role("button", name="Add a window").click()
    await expect(form.locator("[name=start-1]")).to_be_focused()
    await keep(page, "request-form-star")
    await write_darks(form)
    await form.locator("[name=operator]").select_option("SEQUENCE")
    # The order counts: the darks go first, by keyboard.
    await form.get_by_role("button", name="Earlier").focus()
    await page.keyboard.press("Enter")
    await expect(form.get_by_role("button", name="Request 1 no target")).to_be_visible()
    await expect(form.locator("t-request-outlook li")).to_have_count(2)
    await keep(page, "request-form-group")
    await form.get_by_role("button", name="Keep as a draft").click()
    detail = page.locator("t-request-detail")
    await expect(detail.get_by_role("button", name="Change…")).to_be_visible()
    number = page.url.partition("request=")[2]
    before = await group_of(hub, number)
    darks, star = before["requests"]
    assert before["operator"] == "SEQUENCE"
    assert [row["type"] for row in darks["configurations"]] == ["DARK", "BIAS"]
    assert star["target"]["proper_motion_dec"] == 10362.394
    assert star["configurations"][0]["gain"] == 120
    assert star["constraints"]["phase"]["start"] == 0.9
    assert len(star["windows"]) == 2
    # Opened, nothing of it is lost, and what is changed is one field.
    await detail.get_by_role("button", name="Change…").click()
    await form.get_by_role("button", name="Request 2 Barnard's star").click()
    await expect(form.get_by_label("Epoch of the coordinates")).to_have_value("2016")
    await expect(form.get_by_label("Period (days)")).to_have_value("0.56738")
    await form.get_by_label("Priority").fill("11")
    await form.get_by_role("button", name="Keep as a draft").click()
    await expect(detail.get_by_text("priority 11")).to_be_visible()
    number = page.url.partition("request=")[2]
    assert asks(await group_of(hub, number)) == asks({**before, "priority": 11})
    assert page.errors == []


async def test_a_cadence_becomes_its_visits_and_is_asked_for_again(observatory, chromium):
    hub = observatory
    page = await sign_in(chromium, hub, "operator")
    await page.set_viewport_size({"width": 390, "height": 844})
    await page.goto(f"{hub.origin}/sites/{SITE}/requests?new=1")
    form = page.locator("t-request-form")
    await form.locator("[name=target]").fill("Deneb")
    # Enter looks the name up.
    await form.locator("[name=target]").press("Enter")
    await expect(form.locator("[name=dec]")).to_have_value("45.28")
    await form.get_by_text("Again and again (cadence)").click()
    await form.get_by_label("Hours earlier or later").fill("13")
    await form.get_by_role("button", name="Make a request of each visit").click()
    await expect(form.get_by_text("their windows would overlap")).to_be_visible()
    await form.get_by_label("Hours earlier or later").fill("3")
    await form.get_by_label("Visits", exact=True).fill("3")
    await form.get_by_role("button", name="Make 3 requests").click()
    await expect(form.get_by_role("button", name="Request 1 Deneb")).to_be_focused()
    await form.get_by_role("button", name="Request 3 Deneb").click()
    # What is wrong is shown, wherever it is.
    await form.get_by_label("Exposure (s)").fill("long")
    await form.get_by_role("button", name="Request 1 Deneb").click()
    await form.get_by_role("button", name="Keep as a draft").click()
    await expect(form.get_by_text("Request 3: Exposure in s: expected")).to_be_visible()
    await expect(form.get_by_label("Exposure (s)")).to_be_focused()
    await expect(form.get_by_role("button", name="Request 3 Deneb: a field")).to_be_visible()
    await keep(page, "request-form-cadence")
    await page.set_viewport_size({"width": 390, "height": 844})
    await form.get_by_label("Exposure (s)").fill("30")
    await form.get_by_role("button", name="Submit at once").click()
    detail = page.locator("t-request-detail")
    await expect(detail.get_by_role("button", name="Ask again like this…")).to_be_visible()
    width = await page.evaluate("document.documentElement.scrollWidth")
    assert width <= 390
    group = await group_of(hub, page.url.partition("request=")[2])
    starts = [one["windows"][0]["start_us"] for one in group["requests"]]
    assert (group["operator"], len(starts)) == ("MANY", 3)
    assert [after - starts[0] for after in starts] == [0, 1440 * MINUTE_US, 2880 * MINUTE_US]
    await detail.get_by_role("button", name="Ask again like this…").click()
    await expect(form.get_by_role("heading", name="Ask again like")).to_be_visible()
    await form.get_by_role("button", name="Keep as a draft").click()
    await expect(detail.locator("t-status").first).to_contain_text("draft")
    again = await group_of(hub, page.url.partition("request=")[2])
    assert again["id"] != group["id"]
    assert asks(again) == asks(group)
    assert page.errors == []


async def test_what_is_over_is_asked_for_again_from_now_on(observatory, chromium):
    hub = observatory
    client = await hub.client("operator")
    ended = dt.datetime(2024, 3, 1, tzinfo=dt.UTC).timestamp() * 1e6
    one = {
        "target": {"type": "SOLAR_SYSTEM", "body": "moon"},
        "configurations": [{"exposure": 1.0}],
        "windows": [{"start_us": ended - 60 * MINUTE_US, "end_us": ended}],
    }
    asked = {"proposal": "STARS-1", "name": "Old Moon", "requests": [one], "draft": True}
    made = (await client.post(f"{AT}/request-groups", json=asked)).json()
    page = await sign_in(
        chromium, hub, "operator", to=f"/sites/{SITE}/requests?request={made['requests'][0]['id']}"
    )
    await page.get_by_role("button", name="Ask again like this…").click()
    form = page.locator("t-request-form")
    await expect(form.get_by_text("This window is over")).to_have_count(0)
    await form.get_by_role("button", name="Submit at once").click()
    await expect(page.locator("t-request-detail t-status").first).to_contain_text("pending")
    again = await group_of(hub, page.url.partition("request=")[2])
    (window,) = again["requests"][0]["windows"]
    assert window["end_us"] - window["start_us"] == 60 * MINUTE_US
    assert abs(window["start_us"] / 1e6 - time.time()) < 600
