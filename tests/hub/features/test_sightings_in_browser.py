"""The page of sightings in a real Chromium: told while it happens, found, and led on from."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
import pytest
import simplejpeg
from playwright.async_api import expect

from talaia.model.detection import Detect
from talaia.wire import frames
from talaia.wire.browser import SightingUpdate

from ..chromium import sign_in
from ..seeing import seeing

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

FRONT = "camera/front"
SEEING = seeing(Detect())
BEGAN = 1_700_000_000_000_000
MINUTE = 60_000_000
LOADED = "img => img.complete && img.naturalWidth"


def seen(label: str, began_us: int, **more) -> frames.SightingReport:
    told = {"stream": FRONT, "label": label, "many": 1, "confidence": 0.8, "began_us": began_us}
    return frames.SightingReport(**{**told, **more})


async def keep(page, name: str) -> None:
    """Keep a screenshot where a person asked for them."""
    folder = os.environ.get("TALAIA_PICTURES")
    if folder:
        await page.screenshot(path=Path(folder) / f"{name}.png")


async def test_a_sighting_is_on_the_page_while_it_lasts_and_is_found_later(hub, chromium):
    gateway = await hub.gateway()
    await gateway.hello(SEEING)
    told = await hub.page("operator")
    page = await sign_in(chromium, hub, "operator", to="/sites/agv/sightings")
    await expect(page.get_by_text("Nothing seen yet")).to_be_visible()

    picture = simplejpeg.encode_jpeg(np.full((48, 64, 3), 90, np.uint8))
    await gateway.say(seen("person", BEGAN, thumbnail=picture))
    row = page.locator("t-sighting")
    await expect(row).to_contain_text("1 person")
    await expect(row).to_contain_text("in sight")
    await expect(row).to_contain_text("Front camera")
    # Beside the site's own time, UTC.
    await expect(row).to_contain_text("23:13:20 CET")
    await expect(row).to_contain_text("22:13:20 UTC")
    await expect(row.locator("img")).to_be_visible()
    assert await row.locator("img").evaluate(LOADED) == 64

    await gateway.say(seen("person", BEGAN, many=2, confidence=0.9, ended_us=BEGAN + 3 * MINUTE))
    await expect(row).to_contain_text("2 persons")
    await expect(row).to_contain_text("for 3 min")
    await expect(row).not_to_contain_text("in sight")

    await gateway.say(seen("dog", BEGAN + 60 * MINUTE, ended_us=BEGAN + 61 * MINUTE))
    await told.hear(SightingUpdate, lambda news: news.label == "dog")
    await expect(row).to_have_count(2)
    await expect(row.first).to_contain_text("no picture")
    await keep(page, "sightings")

    await page.get_by_label("Detected object").fill("Persons")
    await expect(row).to_have_count(1)
    await expect(row).to_contain_text("2 persons")
    await page.reload()
    await expect(row).to_have_count(1)
    await page.get_by_label("Detected object").fill("zebra")
    await expect(page.get_by_text("No matches")).to_be_visible()
    await page.get_by_role("button", name="Show everything").click()
    await expect(row).to_have_count(2)
    await page.get_by_label("From").fill("2023-11-15T00:00:00")
    await expect(row).to_have_count(1)
    await expect(row).to_contain_text("1 dog")

    await row.get_by_role("link", name="Chart").click()
    await page.wait_for_url(re.compile("/history"))
    # The signal that counts dogs, from a minute before.
    assert f"c={FRONT}_dog" in page.url
    assert f"from={BEGAN + 59 * MINUTE}" in page.url


async def test_who_may_not_see_the_camera_sees_nothing_of_it(hub, chromium):
    gateway = await hub.gateway()
    await gateway.hello(SEEING)
    told = await hub.page("operator")
    await gateway.say(seen("person", BEGAN, ended_us=BEGAN + MINUTE))
    await told.hear(SightingUpdate)
    page = await sign_in(chromium, hub, "guest", to="/sites/agv/sightings")
    await expect(page.get_by_text("No camera looks for anything")).to_be_visible()
    await expect(page.locator("t-sighting")).to_have_count(0)
