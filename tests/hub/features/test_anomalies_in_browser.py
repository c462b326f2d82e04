"""Anomalies in a real Chromium: live strips and marks, "not an anomaly", outliers, the gallery."""

from __future__ import annotations

import asyncio
import time
from contextlib import asynccontextmanager, suppress

import numpy as np
import pytest
from patience import PATIENCE_MS
from playwright.async_api import expect

from talaia.wire.frames import Ack

from ..chromium import sign_in
from ..conftest import DESCRIPTION

pytestmark = [pytest.mark.browser, pytest.mark.timeout(180)]

SPEED = "      speed:\n"
WATCHED = DESCRIPTION.replace(
    SPEED,
    SPEED + "        anomalies: [{detector: limits, maximum: 2, rest: 5}, {detector: iqr}]\n",
    1,
)
PAINTED = (
    "window.__painted = {};"
    "window.__talaiaPainted = (address, us) => { (window.__painted[address] ??= []).push(us); }"
)
COUNT = "(each) => new Set(window.__painted[each] ?? []).size"


class Robot:
    """Sends a speed twenty times a second, as high as it is told."""

    def __init__(self, gateway) -> None:
        """Begin slowly."""
        self.speed = 0.5
        # Speeds of the next samples, before it is ``speed`` again.
        self.next = []
        self._gateway = gateway
        self._sent = 0
        self._news = asyncio.Condition()

    async def run(self) -> None:
        while True:
            now = time.time_ns() // 1000
            speed = self.next.pop() if self.next else self.speed + 0.01 * (self._sent % 5)
            await self._gateway.samples(("base/speed", now, speed))
            async with self._news:
                self._sent += 1
                self._news.notify_all()
            await asyncio.sleep(0.05)

    async def sends(self, many: int) -> None:
        """Wait until so many more samples have gone out."""
        until = self._sent + many
        async with self._news:
            await self._news.wait_for(lambda: self._sent >= until)


@asynccontextmanager
async def driving(hub):
    gateway = await hub.gateway()
    await gateway.hello(WATCHED)
    robot = Robot(gateway)
    running = asyncio.create_task(robot.run())
    try:
        yield robot
    finally:
        running.cancel()
        with suppress(asyncio.CancelledError):
            await running


def tile_of(page, name: str):
    heading = page.get_by_role("heading", name=name, exact=True)
    return page.locator("t-chart-tile").filter(has=heading)


async def test_score_strips_move_with_the_live_chart_and_anomalies_are_marked_as_they_happen(
    hub, chromium
):
    async with driving(hub) as robot:
        page = await sign_in(chromium, hub, "operator")
        await page.add_init_script(PAINTED)
        asked = []
        page.on("request", lambda request: asked.append(request.url))
        await page.goto(f"{hub.origin}/sites/agv/live")
        tile = tile_of(page, "Speed")
        limits = tile.locator("t-detector").filter(has_text="limits")
        await expect(limits).to_contain_text("as usual")
        await expect(tile.locator("t-detector")).to_have_count(2)
        # A signal without detectors has no strip.
        await expect(tile_of(page, "Turn rate").locator("t-detector")).to_have_count(0)
        # The strip moves: it is painted with ever newer scores.
        for address in ("base/speed", "base/speed~limits"):
            before = await page.evaluate(COUNT, address)
            await page.wait_for_function(f"() => ({COUNT})('{address}') > {before + 20}")
        lists = [url for url in asked if url.endswith("/anomalies")]
        robot.speed = 2.5
        await expect(limits.locator("t-status")).to_contain_text("anomaly")
        await expect(limits).to_contain_text("1.00, told from 0.50")
        await expect(limits).to_contain_text("is above the most of 2 m/s")
        assert await tile.locator("t-chart").first.evaluate("each => each.marks.length") >= 1
        mark = "each => [each.marks[0].good, each.marks[0].untilUs === Infinity]"
        assert await limits.locator("t-chart").evaluate(mark) == [False, True]
        robot.speed = 0.5
        await expect(limits.locator("t-status")).to_contain_text("as usual")
        await expect(limits).to_contain_text("Last:")
        # All of it came over the socket: the hub was not asked again.
        assert [url for url in asked if url.endswith("/anomalies")] == lists
        assert page.errors == []


async def test_not_an_anomaly_is_said_at_the_live_chart_by_key_and_every_page_shows_it(
    hub, chromium
):
    async with driving(hub) as robot:
        page = await sign_in(chromium, hub, "operator", to="/sites/agv/live")
        quartiles = tile_of(page, "Speed").locator("t-detector").filter(has_text="quartiles")
        await expect(quartiles).to_contain_text("as usual")
        # It has to know some samples before it has an opinion.
        await robot.sends(40)
        robot.speed = 1.0
        await expect(quartiles.locator("t-status")).to_contain_text("anomaly")
        robot.speed = 0.5
        onlooker = await sign_in(chromium, hub, "guest", to="/sites/agv/live")
        theirs = tile_of(onlooker, "Speed").locator("t-detector").filter(has_text="quartiles")
        # A guest sees why, and may say nothing.
        await expect(theirs).to_contain_text("times the distance of the quartiles above")
        await expect(theirs.get_by_role("button")).to_have_count(0)
        button = quartiles.get_by_role("button", name="Not an anomaly")
        await button.focus()
        await page.keyboard.press("Enter")
        await expect(page.get_by_text("Noted: base/speed is as usual")).to_be_visible()
        for each in (quartiles, theirs):
            await expect(each).to_contain_text("Someone said that it was none")
        await expect(button).to_have_count(0)
        # Limits are changed by hand, and have no such button.
        limits = tile_of(page, "Speed").locator("t-detector").filter(has_text="limits")
        await expect(limits.get_by_role("button")).to_have_count(0)
        assert page.errors == []
        assert onlooker.errors == []


async def test_a_paused_chart_pauses_its_strips(hub, chromium):
    async with driving(hub) as robot:
        page = await sign_in(chromium, hub, "operator")
        await page.add_init_script(PAINTED)
        await page.goto(f"{hub.origin}/sites/agv/live")
        strip = tile_of(page, "Speed").locator("t-detector t-chart").first
        await page.wait_for_function(f"() => ({COUNT})('base/speed~limits') > 5")
        await page.get_by_role("button", name="Pause").first.click()
        await expect(tile_of(page, "Speed")).to_contain_text("Chart paused")
        assert await strip.evaluate("each => each.follow === null && each.span !== null")
        stood = await page.evaluate(COUNT, "base/speed~limits")
        await robot.sends(10)
        assert await page.evaluate(COUNT, "base/speed~limits") == stood


async def test_outliers_of_the_live_chart_are_pointed_out_by_pointer_and_by_key(hub, chromium):
    async with driving(hub) as robot:
        page = await sign_in(chromium, hub, "operator", to="/sites/agv/live")
        tile = tile_of(page, "Speed")
        await expect(tile.locator("t-detector")).to_have_count(2)
        await robot.sends(20)
        robot.next = [1.5]
        await robot.sends(10)
        button = page.get_by_role("button", name="Outliers")
        await button.click()
        await expect(tile.locator("p.outliers")).to_contain_text("of")
        await expect(tile.locator("p.outliers")).to_contain_text("outside")
        points = "each => [...each.outliers.values()].reduce((sum, one) => sum + one.count, 0)"
        assert await tile.locator("t-chart").first.evaluate(points) >= 1
        await page.keyboard.press("Tab")
        await page.keyboard.type("9")
        await page.keyboard.press("Enter")
        field = page.get_by_label("Times the interquartile range")
        await expect(field).to_have_value("9")
        await button.focus()
        await page.keyboard.press(" ")
        await expect(tile.locator("p.outliers")).to_have_count(0)
        # The key meant the button, and not the page's pause.
        await expect(tile).not_to_contain_text("Chart paused")
        assert page.errors == []


COUNTED, STEP_US = 30_000, 10_000


async def test_outliers_of_a_thinned_history_are_those_of_every_stored_sample(
    hub_that_stores, chromium
):
    values = np.random.default_rng(1).normal(0.5, 0.1, COUNTED)
    first, third = np.quantile(values, [0.25, 0.75])
    far = {
        k: int(
            np.count_nonzero(
                (values < first - k * (third - first)) | (values > third + k * (third - first))
            )
        )
        for k in (1.5, 2.0)
    }
    assert 100 < far[1.5] < 400
    now = time.time_ns() // 1000
    begin = now - COUNTED * STEP_US
    async with hub_that_stores() as hub:
        await hub.populate()
        gateway = await hub.gateway()
        await gateway.hello(WATCHED)
        for at in range(0, COUNTED, 1_000):
            rows = [
                ("base/speed", begin + (at + each) * STEP_US, float(values[at + each]))
                for each in range(1_000)
            ]
            await gateway.samples(*rows, live=False)
        await gateway.hear(Ack, lambda ack: ack.below == COUNTED)
        page = await sign_in(chromium, hub, "operator")
        window = f"from={begin - STEP_US}&to={now}"
        await page.goto(f"{hub.origin}/sites/agv/history?c=base/speed&{window}")
        chart = page.locator("t-history-chart")
        await expect(chart.get_by_text("newest shown")).to_be_visible()
        button = page.get_by_role("button", name="Outliers")
        await button.focus()
        await page.keyboard.press("Enter")
        said = chart.get_by_role("status", name="Outliers")
        await expect(said).to_contain_text(f"{far[1.5]} outliers of 30 000 samples")
        shown = (
            "each => [...each.outliers.values()].reduce((sum, one) => sum + one.times.length, 0)"
        )
        # Of a pixel's outliers at most two are drawn, and all drawn ones are outliers.
        assert 50 < await chart.locator("t-chart").evaluate(shown) <= far[1.5]
        await page.get_by_label("Times the interquartile range").fill("2")
        await page.keyboard.press("Tab")
        await expect(said).to_contain_text(f"{far[2.0]} outliers of 30 000 samples")
        await page.wait_for_url("**outliers=2**")
        await button.click()
        await expect(said).to_have_count(0)
        assert page.errors == []


async def test_the_gallery_shows_the_detectors_in_each_state(hub, chromium):
    page = await chromium.new_page(viewport={"width": 390, "height": 844})
    page.set_default_timeout(PATIENCE_MS)
    errors = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    await page.goto(f"{hub.origin}/gallery")
    section = page.locator("section#t-anomalies")

    def figure_of(state: str):
        caption = page.locator("figcaption").get_by_text(state, exact=True)
        return section.locator("figure").filter(has=caption)

    for state, said in (
        ("loading", "Loading the anomaly detectors"),
        ("empty: none watches these signals", "No anomaly detector watches these signals."),
        ("error", "The hub cannot be reached."),
        ("forbidden", "You may not see the anomaly detectors."),
        ("as usual", "as usual"),
        ("on", "Now: 11.2 V is 0.61 V below"),
        ("ended", "Last: 11.2 V is 0.61 V below"),
        ("marked: not an anomaly", "Someone said that it was none"),
    ):
        await expect(figure_of(state)).to_contain_text(said)
    button = "Not an anomaly"
    await expect(figure_of("on").get_by_role("button", name=button)).to_be_visible()
    onlooker = figure_of("ended, for somebody who may only look")
    await expect(onlooker.get_by_role("button", name=button)).to_have_count(0)
    await expect(figure_of("marked: not an anomaly").get_by_role("button")).to_have_count(0)
    refused = figure_of("the mark is refused (press it)")
    await refused.get_by_role("button", name=button).click()
    await expect(refused).to_contain_text("The hub did not tell the detector.")
    learning = page.locator("section#t-detector figure").filter(has_text="learning").first
    await expect(learning).to_contain_text("It learns what is usual for 620 more samples")
    # Nothing is wider than a phone.
    assert await section.evaluate("each => each.scrollWidth <= each.clientWidth")
    assert errors == []


async def test_false_alarms_are_bounded_and_an_anomaly_opens_its_cause(hub, chromium):
    async with driving(hub) as robot:
        page = await sign_in(chromium, hub, "operator", to="/sites/agv/anomalies")
        budget = page.locator("t-alarm-budget")
        await expect(budget).to_contain_text("Each detector goes by its own bar")
        await budget.get_by_label("False alarms a week").fill("2")
        await budget.get_by_role("button", name="Keep to it", exact=True).click()
        await expect(budget).to_contain_text("About 2 false alarms a week for this site.")
        # Limits and quartiles go by bars of their own, and it says so.
        await expect(budget).to_contain_text("No detector at work here can be kept to it")
        robot.speed = 2.5
        speed = page.locator("t-page-anomalies li").filter(has_text="limits")
        await expect(speed).to_contain_text("is above the most of 2 m/s")
        # Scores are stored once a second.
        await robot.sends(60)
        await speed.get_by_role("link", name="Cause", exact=True).click()
        await expect(page.get_by_role("heading", name="Cause", exact=True)).to_be_visible()
        unusual = page.locator("section").filter(has_text="Unusual, the most first")
        await expect(unusual.get_by_role("listitem").first).to_contain_text("Speed")
        await unusual.get_by_role("button", name="It was real", exact=True).click()
        await expect(page.locator("t-page-cause")).to_contain_text("was real.")
        assert page.errors == []
