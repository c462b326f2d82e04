"""Boards in a real Chromium: made of the description, arranged, shared and restored by a person."""

from __future__ import annotations

import time

import pytest
from page_accessibility import find_violations
from playwright.async_api import expect

from talaia.wire.frames import LogLine, RobotLogAck, RobotLogBatch

from ..chromium import sign_in

pytestmark = [pytest.mark.browser, pytest.mark.timeout(180)]
NOW = 1_700_000_000_000_000


async def tile_places(page) -> dict[str, str]:
    """Where each tile stands, as the grid has it."""
    return await page.locator("t-board-grid .cell").evaluate_all(
        "cells => Object.fromEntries(cells.map(cell => [cell.dataset.id, "
        "['--x', '--y', '--w', '--h'].map(name => cell.style.getPropertyValue(name)).join()]))"
    )


async def test_a_person_makes_arranges_shares_and_restores_a_board(chromium, hub, gateway) -> None:
    page = await sign_in(chromium, hub, "operator")
    await gateway.samples(("base/turn_rate", NOW, 0.5))
    # The first board is there without a click: it is made of the description.
    await page.goto(f"{hub.origin}/boards")
    await page.get_by_role("link", name="Cockpit of").click()
    await expect(page.locator("t-board-tile").first).to_be_visible()
    # On a phone nothing is wider than the phone.
    await page.set_viewport_size({"width": 390, "height": 844})
    await expect(page.get_by_text("0.500").first).to_be_visible()
    assert await page.evaluate("document.documentElement.scrollWidth") <= 390
    await page.set_viewport_size({"width": 1440, "height": 900})
    await page.get_by_role("button", name="Save a copy to arrange").click()
    bar = page.get_by_role("region", name="Arrange the board")
    await expect(bar).to_be_visible()
    before = await tile_places(page)

    # By keys, by the mouse, and one more tile whose form its schema makes.
    await bar.get_by_label("Name").fill("My cockpit")
    grip = page.get_by_role("button", name="Move").first
    await grip.focus()
    await page.keyboard.press("Shift+ArrowDown")
    keyed = await tile_places(page)
    assert keyed != before
    corner = page.locator("t-board-grid .cell .corner").first
    await corner.scroll_into_view_if_needed()
    box = await corner.bounding_box()
    await page.mouse.move(box["x"] + 10, box["y"] + 10)
    await page.mouse.down()
    await page.mouse.move(box["x"] - 190, box["y"] + 10, steps=4)
    await page.mouse.up()
    assert await tile_places(page) != keyed
    await bar.get_by_role("button", name="Add a tile").click()
    await page.get_by_role("button", name="Text and links").click()
    settings = page.locator("t-tile-form")
    await settings.get_by_label("Text", exact=True).fill("Mind the step")
    await settings.get_by_label("Links").fill("Bad | javascript:alert(1)\nAlarms | /alarms")
    await page.get_by_role("button", name="Done").click()
    await bar.get_by_role("button", name="Save", exact=True).click()
    await expect(page.get_by_text("version 2", exact=False)).to_be_visible()
    await expect(page.get_by_text("Mind the step")).to_be_visible()
    await expect(page.locator("t-tile-text a")).to_have_count(1)

    # Shared with who may view the site; a guest, who may not, is told no more than that.
    await page.get_by_role("button", name="More of this board").click()
    await page.get_by_role("button", name="Share…").click()
    await page.get_by_role("radio", name="Who may view").check()
    await page.get_by_role("button", name="Share it so").click()
    await expect(page.get_by_role("dialog", name="Who sees this board")).to_be_hidden()
    address = page.url.partition("?")[0]
    admin = await sign_in(chromium, hub, "admin")
    await admin.goto(address)
    await expect(admin.get_by_role("heading", name="My cockpit")).to_be_visible()
    guest = await sign_in(chromium, hub, "guest")
    await guest.goto(address)
    await expect(guest.get_by_text("This board is not open to you")).to_be_visible()

    # Back to the first version: everything is where it was.
    await page.get_by_role("button", name="More of this board").click()
    await page.get_by_role("button", name="Versions…").click()
    await page.get_by_role("button", name="Restore version 1").click()
    await expect(page.get_by_text("version 3", exact=False)).to_be_visible()
    await expect(page.get_by_role("heading", name="Cockpit of")).to_be_visible()
    assert await tile_places(page) == before
    assert page.errors == admin.errors == guest.errors == []


async def test_who_may_see_little_is_told_so_tile_by_tile(chromium, hub, gateway) -> None:
    admin = await hub.client("admin")
    place = {"x": 0, "y": 0, "w": 4, "h": 2}
    tile = {"type": "value", "title": "", "desktop": place, "phone": None}
    tiles = [
        {**tile, "id": "t1", "settings": {"signal": "base/turn_rate"}},
        {**tile, "id": "t2", "settings": {}},
        {**tile, "id": "t3", "type": "hologram", "settings": {}},
    ]
    board = {"name": "Hall", "note": "", "site": "agv", "kind": "", "device": "", "tiles": tiles}
    key = (await admin.post("/api/boards", json={"board": board})).json()["key"]
    assert (await admin.put(f"/api/boards/{key}/public", json={})).status_code == 204
    guest = await sign_in(chromium, hub, "guest", to=f"/boards/{key}?kiosk=1")
    states = guest.locator("t-board-tile [data-state]")
    await expect(states).to_have_count(3)
    found = await states.evaluate_all("each => each.map(one => one.dataset.state).sort()")
    assert found == ["empty", "error", "forbidden"]
    # Nothing of the dashboard stands around it, on a phone neither.
    await guest.set_viewport_size({"width": 390, "height": 844})
    assert await guest.evaluate("document.documentElement.scrollWidth") <= 390
    assert await find_violations(guest) == []
    assert guest.errors == []


async def test_one_board_serves_each_robot_of_a_kind_and_says_what_one_of_them_lacks(
    chromium, hub, gateway
) -> None:
    operator = await hub.client("operator")
    tile = {"id": "t1", "type": "chart", "title": "Turning", "desktop": None, "phone": None}
    signals = ["base/turn_rate", "base/removed", "@battery.level"]
    tiles = [{**tile, "settings": {"signals": signals}}]
    board = {"name": "Each", "note": "", "site": "agv", "kind": "", "device": "", "tiles": tiles}
    key = (await operator.post("/api/boards", json={"board": board})).json()["key"]
    page = await sign_in(chromium, hub, "operator", to=f"/boards/{key}")
    # What is there is drawn, and what is not is named beside the title.
    chart = page.locator("t-board-tile").first
    await expect(chart.get_by_text("without base/removed")).to_be_visible()
    await page.get_by_role("button", name="Arrange").click()
    bar = page.get_by_role("region", name="Arrange the board")
    await bar.get_by_label("Site").select_option(label="any site")
    await bar.get_by_label("Kind of device").select_option("vehicle")
    await page.get_by_role("button", name="Settings of Turning").click()
    form = page.locator("t-tile-form")
    gone = form.get_by_role("checkbox", name="base/removed (not here)")
    await expect(gone).to_be_checked()
    await gone.uncheck()
    await expect(gone).to_have_count(0)
    await page.get_by_role("button", name="Done").click()
    # A command of whichever device is chosen above the board.
    await bar.get_by_role("button", name="Add a tile").click()
    await page.get_by_role("button", name="Command A button").click()
    await form.get_by_label("Command").select_option(label="Wander about of the chosen device")
    await page.get_by_role("button", name="Done").click()
    await bar.get_by_role("button", name="Save", exact=True).click()
    await expect(page.get_by_text("version 2", exact=False)).to_be_visible()
    await expect(page.get_by_role("button", name="Send")).to_be_visible()
    await expect(page.get_by_text("without base/removed")).to_have_count(0)
    kept = (await operator.get(f"/api/boards/{key}")).json()["board"]
    assert (kept["site"], kept["kind"]) == ("", "vehicle")
    assert [tile["settings"] for tile in kept["tiles"]] == [
        {"signals": ["base/turn_rate", "@battery.level"]},
        {"command": "$device/wander"},
    ]

    # It goes out as a file, and comes back the same; another file is told what it lacks.
    await page.get_by_role("button", name="More of this board").click()
    async with page.expect_download() as saved:
        await page.get_by_role("button", name="Export as YAML").click()
    await page.goto(f"{hub.origin}/boards")
    file = page.get_by_label("A board's file")
    wrong = {"name": "site.yaml", "mimeType": "text/yaml", "buffer": b"talaia: 1"}
    await file.set_input_files(wrong)
    await expect(page.get_by_text("The file is no board: $.board")).to_be_visible()
    await file.set_input_files(await (await saved.value).path())
    await expect(bar).to_be_visible()
    rows = (await operator.get("/api/boards")).json()["boards"]
    (other,) = {row["key"] for row in rows} - {key}
    assert (await operator.get(f"/api/boards/{other}")).json()["board"] == kept
    assert page.errors == []


PAST_TILES = {
    "value": {"signal": "base/turn_rate"},
    "gauge": {"signal": "base/turn_rate"},
    "chart": {"signals": ["base/turn_rate"], "seconds": 60},
    "timeline": {"signals": ["base/wandering"], "seconds": 60},
    "table": {"signals": ["base/pose", "power/charge"]},
    "trail": {"signal": "base/pose"},
    "camera": {"stream": "camera/front"},
    "command": {"command": "base/wander"},
    "topic": {"topic": "/odom"},
    "drive": {"device": "base"},
    "logbook": {},
}


async def test_a_board_in_the_past_shows_it_and_sends_nothing(chromium, hub, gateway) -> None:
    operator = await hub.client("operator")
    # Without a place each goes where there is room.
    nowhere = {"desktop": None, "phone": None}
    tiles = [
        {"id": f"t{at}", "type": kind, "title": "", "settings": settings, **nowhere}
        for at, (kind, settings) in enumerate(PAST_TILES.items())
    ]
    board = {"name": "Then", "note": "", "site": "agv", "kind": "", "device": "", "tiles": tiles}
    key = (await operator.post("/api/boards", json={"board": board})).json()["key"]
    rows = [
        row
        for second in range(90)
        for row in (
            ("base/turn_rate", NOW + second * 1_000_000, second / 100),
            ("base/pose.x", NOW + second * 1_000_000, second / 10),
            ("base/pose.y", NOW + second * 1_000_000, 0.0),
            ("base/wandering", NOW + second * 1_000_000, second // 30 % 2),
        )
    ]
    await gateway.samples(*rows, live=False)
    # What comes now is seen now, and never in the past.
    await gateway.samples(("base/turn_rate", time.time_ns() // 1000, 2.5))
    page = await sign_in(chromium, hub, "operator", to=f"/boards/{key}?at=2023-11-14T22:14:20Z")
    bar = page.locator("t-time-bar")
    await expect(bar.locator("time")).to_have_text("14 Nov 2023, 23:14:20 CET")
    await expect(bar.get_by_text("22:14:20 UTC")).to_be_visible()
    value = page.locator("t-tile-gauge t-value")
    await expect(value).to_contain_text("0.6")
    await expect(page.locator("t-signal-value").first).to_contain_text("0.600")
    assert await page.get_by_text("2.500").count() == 0
    for words in ("Nothing was recorded at this moment", "nothing recorded", "x 6.00 m"):
        await expect(page.get_by_text(words).first).to_be_visible()
    # Nothing is sent from here, which is said; STOP is there as ever.
    await expect(page.get_by_text("commands go out only from now").first).to_be_visible()
    await expect(page.get_by_text("nothing is driven from it")).to_be_visible()
    assert await page.locator("t-tile-drive").get_by_role("button", name="STOP").is_enabled()
    assert await page.locator("t-drive-pad").count() == 0

    # A step, a scrub by keys, and playing move everything; the address follows.
    await bar.get_by_role("button", name="−1 s").click()
    await expect(value).to_contain_text("0.59")
    await page.wait_for_url("**at=2023-11-14T22%3A14%3A19.000Z")
    await bar.get_by_role("slider", name="Moment").press("PageDown")
    await expect(value).to_contain_text("0.49")
    await bar.get_by_label("Speed").select_option("10")
    await bar.get_by_role("button", name="Play").click()
    await expect(value).to_contain_text("0.8")
    await bar.get_by_role("button", name="Pause").click()
    # A moment that no bar reaches is written, by the site's clock; what is none moves nothing.
    go = bar.get_by_label("Go to a moment (Europe/Madrid)")
    await go.fill("yesterday")
    await go.press("Enter")
    await expect(bar.get_by_text("Write it like")).to_be_visible()
    await go.fill("2023-11-14 23:14:08")
    await go.press("Enter")
    await expect(value).to_contain_text("0.48")
    await page.wait_for_url("**at=2023-11-14T22%3A14%3A08.000Z")
    # Long after the last sample nothing is shown as if it were of then.
    await page.goto(f"{hub.origin}/boards/{key}?at=2023-11-15T22:14:20Z")
    await expect(bar.get_by_text("No value was recorded in the minute before")).to_be_visible()
    await expect(value).to_have_attribute("state", "stale")

    await page.set_viewport_size({"width": 390, "height": 844})
    assert await page.evaluate("document.documentElement.scrollWidth") <= 390
    assert await find_violations(page) == []
    await bar.get_by_role("button", name="Back to now").click()
    await expect(bar).to_have_count(0)
    await page.set_viewport_size({"width": 1440, "height": 900})
    await expect(page.locator("t-signal-value").first).to_contain_text("2.500")
    # A line of the logbook leads to the board of its moment.
    await page.goto(f"{hub.origin}/sites/agv/logbook")
    await page.get_by_role("link", name="Board then").first.click()
    await page.wait_for_url("**/boards/template%3Aagv?at=20*Z")
    await expect(bar.locator("time")).to_be_visible()
    # What happened stands on the bar.
    mark = page.locator("t-time-bar .mark").last
    await expect(mark).to_be_visible()
    # At its place: a moment ago is at the right end.
    assert (await mark.bounding_box())["x"] > 720
    assert page.errors == []


async def test_a_tile_shows_what_was_kept_of_a_robots_log_and_finds_words_in_it(
    chromium, hub, gateway
) -> None:
    operator = await hub.client("operator")
    tile = {"id": "t1", "type": "log", "title": "", "desktop": None, "phone": None}
    tiles = [{**tile, "settings": {"level": "30"}}]
    board = {"name": "Log", "note": "", "site": "agv", "kind": "", "device": "", "tiles": tiles}
    key = (await operator.post("/api/boards", json={"board": board})).json()["key"]
    now_us = time.time_ns() // 1000
    said = [
        LogLine(
            time_us=now_us - (450 - at) * 1_000_000, level=40 if at == 7 else 30, node="pump",
            text="the pump is dry" if at == 7 else f"low pressure {at}",
        )
        for at in range(450)
    ]  # fmt: skip
    for first in (0, 150, 300):
        batch = RobotLogBatch(boot="run", first=first, lines=said[first : first + 150])
        await gateway.say(batch)
        assert (await gateway.hear(RobotLogAck)).below == first + 150
    page = await sign_in(chromium, hub, "operator", to=f"/boards/{key}")
    lines = page.get_by_role("list", name="Lines, the newest first")
    await expect(lines).to_contain_text("low pressure 449")
    await expect(lines).not_to_contain_text("the pump is dry")
    # The oldest is on a page further down, and is found by its words at once.
    older = lines.get_by_role("button", name="Older")
    await older.click()
    await expect(lines).to_contain_text("low pressure 100")
    await older.click()
    await expect(lines).to_contain_text("the pump is dry")
    await expect(older).to_be_hidden()
    await page.reload()
    await page.get_by_role("searchbox", name="Search the log").fill("DRY")
    await expect(lines.get_by_role("listitem")).to_have_count(1)
    await expect(lines).to_contain_text("the pump is dry")
    assert page.errors == []
