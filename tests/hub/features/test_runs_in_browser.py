"""Two runs in a real Chromium: charts laid over each other, and two boards under one bar."""

from __future__ import annotations

import pytest
from playwright.async_api import expect

from ..chromium import sign_in

pytestmark = [pytest.mark.browser, pytest.mark.timeout(600)]
NOW = 1_700_000_000_000_000
# An hour later the same again, half as much more everywhere.
LATER = NOW + 3_600_000_000


async def test_two_runs_are_laid_over_each_other_and_played_side_by_side(
    chromium, hub, gateway
) -> None:
    for start, more in ((NOW, 0.0), (LATER, 0.5)):
        rows = [
            ("base/turn_rate", start + second * 1_000_000, second / 100 + more)
            for second in range(90)
        ]
        await gateway.samples(*rows, live=False)
    operator = await hub.client("operator")
    for start, text in ((NOW, "Dry run"), (LATER, "Wet run")):
        span = {"from_us": start, "to_us": start + 60_000_000}
        body = {"device": "base", "signal": "", "text": text, **span}
        assert (await operator.post("/api/sites/agv/notes", json=body)).status_code == 201
    page = await sign_in(chromium, hub, "operator", to="/sites/agv/history?c=base/turn_rate")
    await page.get_by_role("button", name="Compare runs").click()
    dialog = page.locator("t-run-picker")
    runs = {
        text: await dialog.locator("option", has_text=text).first.get_attribute("value")
        for text in ("Wet run", "Dry run")
    }
    await dialog.get_by_label("First run", exact=True).select_option(runs["Wet run"])
    await dialog.get_by_label("Second run", exact=True).select_option(runs["Dry run"])
    await dialog.get_by_role("button", name="Compare").click()
    await page.wait_for_url(f"**from={LATER}&to={LATER + 60_000_000}&shift=3600000000")
    # Half a radian a second at every sample, and so by root mean square, too.
    await expect(page.get_by_text("RMS difference 0.500")).to_be_visible()
    await page.get_by_role("button", name="End the comparison").click()
    await expect(page.get_by_text("RMS difference")).to_have_count(0)

    # A board of both: each tile shows its own run, and one bar moves them.
    places = {"desktop": None, "phone": None}
    settings = {"signal": "base/turn_rate"}
    tile = {"id": "t1", "type": "gauge", "title": "", "settings": settings, **places}
    board = {"name": "Runs", "note": "", "site": "agv", "kind": "", "device": "", "tiles": [tile]}
    key = (await operator.post("/api/boards", json={"board": board})).json()["key"]
    # 20 s after the start of each.
    moments = "at=2023-11-14T23:13:40Z&with=2023-11-14T22:13:40Z"
    await page.goto(f"{hub.origin}/boards/{key}?{moments}")
    values = page.locator("t-tile-gauge t-value")
    await expect(values).to_have_count(2)
    await expect(values.first).to_contain_text("0.7")
    await expect(values.last).to_contain_text("0.2")
    bar = page.locator("t-time-bar")
    await bar.get_by_role("slider", name="Moment").press("PageUp")
    await expect(values.first).to_contain_text("0.8")
    await expect(values.last).to_contain_text("0.3")
    await bar.get_by_label("Speed").select_option("10")
    await bar.get_by_role("button", name="Play").click()
    await expect(values.first).to_contain_text("1.2")
    await bar.get_by_role("button", name="Pause").click()
    await page.wait_for_url("**with=2023-11-14T22*")
    await bar.get_by_role("button", name="End the comparison").click()
    await expect(values).to_have_count(1)
    assert page.errors == []
