"""A site judged in a real Chromium, from learning what is normal to a day looked through.

The pages' details have tests of their own; here each step stands on what the one before it left.
"""

from __future__ import annotations

import asyncio
import time

import numpy as np
import pytest
from playwright.async_api import expect

from talaia.model.detection import Detect
from talaia.model.yaml_text.load import load_site
from talaia.wire import frames
from talaia.wire.browser import SightingUpdate

from ..chromium import sign_in
from ..seeing import seeing
from .test_pages_in_browser import WIDTH
from .test_review_in_browser import picture
from .test_zones_in_browser import apply_change, described, film, keep

pytestmark = [pytest.mark.browser, pytest.mark.timeout(600)]

GROUPED = """
anomaly_groups:
  body:
    name: The body
    signals: [base/speed, base/turn_rate, power/voltage]
"""
SECOND = 1_000_000
# 13:00 by the site's clock.
NOON = 1_700_049_600_000_000


class Vehicle:
    """A vehicle whose voltage falls under load, and a camera at its front."""

    def __init__(self, gateway) -> None:
        """Begin five minutes ago."""
        self._gateway = gateway
        self._chance = np.random.default_rng(1)
        self._begin_us = time.time_ns() // 1000 - 300 * SECOND

    async def connect(self) -> None:
        site = load_site(seeing(Detect(classes=("person",))) + GROUPED)
        self._gateway.boot = "boot-1"
        self._gateway.channels = {channel.address: at for at, channel in enumerate(site.channels())}
        text = described(seeing(Detect(classes=("person",))) + GROUPED)
        await self._gateway.say(
            frames.Hello(
                site="agv", boot="boot-1", accepts="readings", **{**text, "catalogue": "c1"}
            )
        )
        await self._gateway.hear(frames.Welcome)

    async def drive(self, seconds: range, voltage: float) -> None:
        for at in seconds:
            load, turn, noise = self._chance.normal(size=3)
            now = self._begin_us + at * SECOND
            await self._gateway.samples(
                ("base/speed", now, 0.5 + 0.05 * load),
                ("base/turn_rate", now, 0.01 * turn),
                ("power/voltage", now, voltage - 0.1 * load + 0.01 * noise),
            )

    async def sight(self, minute: int, *stays: frames.ZoneStay) -> None:
        began = NOON + minute * 60 * SECOND
        await self._gateway.say(
            frames.SightingReport(
                stream="camera/front", label="person", many=1, confidence=0.8, began_us=began,
                ended_us=began + 20 * SECOND, thumbnail=picture(30 * minute + 40),
                stays=list(stays),
            )
        )  # fmt: skip


async def look_at_both_sizes(page, name: str) -> None:
    """Nothing is wider than a phone; pictures are kept where a person asked for them."""
    await page.set_viewport_size({"width": 390, "height": 900})
    assert await page.evaluate(WIDTH) <= 390
    await page.set_viewport_size({"width": 1440, "height": 900})
    await keep(page, name)


async def learn_from_the_run(page, group) -> None:
    await expect(group).to_contain_text("3 signals once a second")
    await expect(group.locator("t-status")).to_contain_text("learning")
    form = page.locator("t-learn-form")
    begins = form.get_by_label("From")
    hour_ago = await begins.input_value()
    button = form.get_by_role("button", name="Learn from it")
    await begins.fill("yesterday")
    await button.click()
    await expect(form).to_contain_text("Write it like 2026-03-29 14:05:09.")
    # The hour that stands there by itself holds the run.
    await begins.fill(hour_ago)
    await button.click()
    await expect(form).to_contain_text("The body has learned from 200 steps")
    await expect(group.locator("t-status")).to_contain_text("as usual")


async def try_the_past(page, *, a_finds: str) -> None:
    """Try two settings on the past; nothing is as far from usual as a bar of 1 asks for."""
    trial = page.locator("t-back-test")
    await trial.get_by_label("A: learns from (steps)").fill("120")
    await trial.get_by_label("B: learns from (steps)").fill("120")
    await trial.get_by_label("B: told from").fill("1")
    await trial.get_by_role("button", name="Try both").click()
    for setting, found in (("Setting A", a_finds), ("Setting B", "0 anomalies")):
        result = trial.locator("t-test-result").filter(has_text=setting)
        await expect(result).to_contain_text("done")
        await expect(result).to_contain_text(found)
        await expect(result).to_contain_text("s of a core")


async def see_the_cause(page, hub) -> None:
    await page.get_by_role("link", name="Cause of The body").click()
    unusual = page.locator("section").filter(has_text="Unusual, the most first")
    await expect(unusual.get_by_role("listitem").first).to_contain_text("The body")
    # And which of its signals made it so.
    made_so = unusual.get_by_role("list", name="What made it so").get_by_role("listitem")
    await expect(made_so.first).to_contain_text("Battery, Voltage")
    await look_at_both_sizes(page, "walk-cause")
    await page.goto(f"{hub.origin}/sites/agv/live")
    heading = page.get_by_role("heading", name="Voltage", exact=True)
    tile = page.locator("t-chart-tile").filter(has=heading)
    await expect(tile).to_contain_text("of it by this signal")
    await look_at_both_sizes(page, "walk-live")


async def draw_a_zone(page, hub, gateway) -> None:
    """Draw a zone over the live picture; the gateway goes by it."""
    camera = await hub.camera()
    await page.goto(f"{hub.origin}/sites/agv/zones?camera=camera/front")
    filming = asyncio.create_task(film(camera))
    try:
        await expect(page.locator("t-camera .badge")).to_contain_text("Live")
        await page.get_by_role("button", name="Add zone").click()
        await page.get_by_label("Zone, name").fill("Charging place")
        await look_at_both_sizes(page, "walk-zone")
        await page.get_by_role("button", name="Review and apply").click()
        going = asyncio.create_task(apply_change(gateway))
        await page.get_by_role("button", name="Apply", exact=True).click()
        text = await going
        await expect(page.locator("t-shape-list")).to_contain_text("\u2013 person")
    finally:
        filming.cancel()
        await asyncio.gather(filming, return_exceptions=True)
    zones = load_site(text).devices["camera"].streams["front"].detect.zones
    assert [zone.name for zone in zones.values()] == ["Charging place"]


async def review_the_day(page, hub) -> None:
    await page.goto(f"{hub.origin}/sites/agv/review")
    rows = page.locator("li[data-sighting]")
    await expect(rows).to_have_count(3)
    stage = page.get_by_label("Shown now")
    await expect(stage).to_contain_text("13:03:00")
    await page.keyboard.press("j")
    await expect(stage).to_contain_text("13:02:00")
    await expect(stage).to_contain_text("12 s in Charging place")
    await look_at_both_sizes(page, "walk-review")
    # Only what was in the zone that was drawn; and then all the rest.
    await page.get_by_label("Zone or line").select_option("Charging place")
    await expect(rows).to_have_count(1)
    await page.keyboard.press("s")
    await page.get_by_label("Zone or line").select_option("")
    days = page.get_by_role("navigation", name="Days")
    await expect(days.get_by_role("link").first).to_contain_text("2 new of 3")
    await page.get_by_role("button", name="All of these seen").click()
    await expect(days.get_by_role("link").first).to_contain_text("all 3 seen")


async def test_a_person_learns_from_a_run_tries_it_finds_a_fault_draws_a_zone_and_reviews_a_day(
    hub, chromium
):
    gateway = await hub.gateway()
    vehicle = Vehicle(gateway)
    await vehicle.connect()
    await vehicle.drive(range(200), 12.0)
    page = await sign_in(chromium, hub, "admin", to="/sites/agv/anomalies")
    group = page.locator("t-detector").filter(has_text="The body")
    await learn_from_the_run(page, group)
    await try_the_past(page, a_finds="0 anomalies")

    await vehicle.drive(range(200, 260), 10.0)
    await expect(group.locator("t-status")).to_contain_text("anomaly")
    first = group.locator("t-signal-shares li").first
    await expect(first).to_contain_text("Battery, Voltage")
    await expect(first).to_contain_text("spreads below its level")
    # The same test finds what was planted.
    await try_the_past(page, a_finds="Battery Voltage (")
    await look_at_both_sizes(page, "walk-anomalies")
    await see_the_cause(page, hub)

    await draw_a_zone(page, hub, gateway)
    told = await hub.page("operator")
    await vehicle.sight(1)
    await vehicle.sight(2, frames.ZoneStay(zone="Charging place", entries=1, dwell_s=12.0))
    await vehicle.sight(3)
    await told.hear(SightingUpdate, lambda news: news.began_us == NOON + 180 * SECOND)
    await review_the_day(page, hub)
    assert page.errors == []
