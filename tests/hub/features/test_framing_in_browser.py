"""A field is framed over the sky in a real Chromium, and a mosaic of it is handed in."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.async_api import expect

from talaia.imaging.tangent_plane import angular_distance

from ..chromium import sign_in
from .test_night_in_browser import keep

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]

SITE = "observatory"
EXAMPLES = Path(__file__).parents[3] / "examples"
# Of the example with a rotator.
WIDTH, HEIGHT = 0.4238, 0.3389
AT = f"/api/sites/{SITE}"
PROPOSAL = {"id": "STARS-1", "title": "Stars", "hours_allocated": 200.0, "share": 0.5}
M31 = 10.68475, 41.26908


async def observe(hub, example: str):
    """Give a hub an observatory, and a proposal of which the operator is a member."""
    described = (EXAMPLES / example / "site.yaml").read_text()
    hub.dome = await hub.gateway(key=await hub.hub.gateways.registry.new_key(SITE))
    await hub.dome.hello(described.replace(f"site: {example}", f"site: {SITE}"), site=SITE)
    admin = await hub.client("admin")
    assert (await admin.post(f"{AT}/proposals", json=PROPOSAL)).status_code == 201
    await admin.put(f"{AT}/proposals/STARS-1/members", json={"name": "operator", "role": "member"})


async def place_of(form) -> tuple[float, float]:
    """Give the target (°) as its fields say."""
    ra = await form.locator("[name=ra]").input_value()
    dec = await form.locator("[name=dec]").input_value()
    hours, minutes, seconds = (float(part) for part in ra.split(":"))
    sign = -1 if dec[0] in "-\u2212" else 1
    degrees, arcmin, arcsec = (float(part) for part in dec.lstrip("+-\u2212").split(":"))
    return 15 * (hours + minutes / 60 + seconds / 3600), sign * (
        degrees + arcmin / 60 + arcsec / 3600
    )


async def open_framing(page, form) -> None:
    await form.locator("[name=target]").fill("M 31")
    await form.locator("[name=ra]").fill("00:42:44.34")
    await form.locator("[name=dec]").fill("+41:16:08.7")
    await form.get_by_text("What the camera shows, and mosaics").click()
    # Its stars have come.
    await expect(page.locator("t-framing-view .star").first).to_be_attached()


async def test_a_mosaic_is_framed_turned_and_handed_in_as_a_request_for_each_panel(
    hub, chromium
) -> None:
    await observe(hub, "indi")
    page = await sign_in(chromium, hub, "operator", to=f"/sites/{SITE}/requests?new=1")
    form = page.locator("t-request-form")
    await form.locator("[name=name]").fill("The whole galaxy")
    await open_framing(page, form)
    view = page.locator("t-framing-view svg")
    # By the keys: a tenth of the height to the north, and with Shift a hundredth to the west.
    await view.focus()
    await page.keyboard.press("ArrowUp")
    ra, dec = await place_of(form)
    assert dec == pytest.approx(M31[1] + HEIGHT / 10, abs=3e-4)
    await page.keyboard.press("Shift+ArrowRight")
    assert angular_distance(*await place_of(form), ra, dec) == pytest.approx(HEIGHT / 100, abs=3e-4)
    # By hand: a drawing of 1.59° from side to side.
    await page.locator("t-framing-view .panel").scroll_into_view_if_needed()
    before, box = await place_of(form), await view.bounding_box()
    frame = await page.locator("t-framing-view .panel").bounding_box()
    x, y = frame["x"] + frame["width"] / 2, frame["y"] + frame["height"] / 2
    await page.mouse.move(x, y)
    await page.mouse.down()
    await page.mouse.move(x + box["width"] / 20, y, steps=3)
    await page.mouse.move(x + box["width"] / 10, y, steps=3)
    await page.mouse.up()
    span = 3 * (WIDTH**2 + HEIGHT**2) ** 0.5
    moved = angular_distance(*await place_of(form), *before)
    assert moved == pytest.approx(span / 10, rel=0.03)
    assert (await place_of(form))[0] < before[0]
    # Turned, and as a mosaic.
    await form.get_by_label("Position angle").fill("35")
    await form.get_by_label("Panels across").fill("2")
    await form.get_by_label("Panels down").fill("3")
    await form.get_by_label("Overlap").fill("20")
    await expect(page.locator("t-framing-view .panel")).to_have_count(6)
    await expect(form.get_by_text("6 panels show 45.8′ × 52.9′: open shutter 1 h")).to_be_visible()
    await keep(page, "framing-mosaic")
    await form.get_by_role("button", name="Make 6 requests, one for each panel").click()
    await expect(form.get_by_role("button", name="Request 6 M 31 panel 3-2")).to_be_visible()
    # The hub says what all of it is charged.
    await expect(form.locator("t-request-outlook li")).to_have_count(6)
    await keep(page, "framing-panels")
    await form.get_by_role("button", name="Back to before the panels").click()
    await expect(form.get_by_text("One request", exact=True)).to_be_visible()
    await form.get_by_label("Panels across").fill("2")
    await form.get_by_label("Panels down").fill("3")
    await form.get_by_role("button", name="Make 6 requests, one for each panel").click()
    await form.get_by_role("button", name="Keep as a draft").click()
    detail = page.locator("t-request-detail")
    await expect(detail.get_by_text("35.26°, of the top")).to_be_visible()
    number = page.url.partition("request=")[2]
    client = await hub.client("operator")
    group = (await client.get(f"{AT}/requests/{number}")).json()["group"]
    targets = [one["target"] for one in group["requests"]]
    assert (group["operator"], len(targets)) == ("MANY", 6)
    assert targets[0]["name"] == "M 31 panel 1-1"
    # Neighbours share what was asked; each panel is turned a little with its own meridian.
    first, beside, below = targets[0], targets[1], targets[2]
    apart = angular_distance(first["ra"], first["dec"], beside["ra"], beside["dec"])
    assert apart == pytest.approx(WIDTH * 0.8, abs=1e-3)
    apart = angular_distance(first["ra"], first["dec"], below["ra"], below["dec"])
    assert apart == pytest.approx(HEIGHT * 0.8, abs=1e-3)
    angles = [target["position_angle"] for target in targets]
    assert angles == pytest.approx([35.0] * 6, abs=0.6)
    assert len(set(angles)) == 6
    assert group["charge_s"] > 6 * 600
    assert page.errors == []


async def test_on_a_phone_a_camera_that_does_not_turn_is_framed_beside_what_scrolls(
    hub, chromium
) -> None:
    await observe(hub, "observatory")
    page = await sign_in(chromium, hub, "operator")
    await page.set_viewport_size({"width": 390, "height": 844})
    await page.goto(f"{hub.origin}/sites/{SITE}/requests?new=1")
    form = page.locator("t-request-form")
    await open_framing(page, form)
    await expect(form.get_by_text("Its position angle is 0°, and fixed")).to_be_visible()
    await expect(form.get_by_label("Position angle")).to_have_count(0)
    assert await page.evaluate("document.documentElement.scrollWidth") == 390
    # Near the pole it says what that means, and the panels ask for no angle.
    await form.locator("[name=dec]").fill("+89:50:00")
    await form.get_by_label("Panels across").fill("3")
    await expect(form.get_by_text("panels are turned against each other")).to_be_visible()
    await keep(page, "framing-pole")
    await form.get_by_role("button", name="Make 3 requests, one for each panel").click()
    await form.get_by_role("button", name="Keep as a draft").click()
    await expect(page.locator("t-request-detail")).to_be_visible()
    number = page.url.partition("request=")[2]
    client = await hub.client("operator")
    group = (await client.get(f"{AT}/requests/{number}")).json()["group"]
    assert [one["target"]["position_angle"] for one in group["requests"]] == [None] * 3
    assert page.errors == []
