"""Notes in a real Chromium: written on a past board, over a chart's stretch and in the logbook."""

from __future__ import annotations

import pytest
from page_accessibility import find_violations
from playwright.async_api import expect

from ..chromium import sign_in

pytestmark = [pytest.mark.browser, pytest.mark.timeout(600)]
NOW = 1_700_000_000_000_000
NOTES = "/api/sites/agv/notes"


async def test_a_note_is_written_on_the_past_board_s_bar_and_found_everywhere(
    chromium, hub, gateway
) -> None:
    rows = [("base/turn_rate", NOW + second * 1_000_000, second / 100) for second in range(90)]
    await gateway.samples(*rows, live=False)
    operator = await hub.client("operator")
    page = await sign_in(
        chromium, hub, "operator", to="/boards/template:agv?at=2023-11-14T22:14:20Z"
    )
    bar = page.locator("t-time-bar")
    await bar.get_by_role("button", name="Begin a span").click()
    await bar.get_by_role("slider", name="Moment").press("PageDown")
    await bar.get_by_role("button", name="Note since 23:14:20").click()
    # What is slotted into a dialog lies beside it in the page.
    dialog = page.locator("t-note-dialog")
    await dialog.get_by_role("button", name="Save").click()
    await expect(dialog.get_by_text("Write some words.")).to_be_visible()
    await dialog.get_by_label("Text").fill("The left wheel slips\non wet ground")
    await dialog.get_by_label("About").select_option("base")
    await dialog.get_by_label("Signal").select_option("turn_rate")
    await dialog.get_by_role("button", name="Save").click()
    await expect(page.get_by_role("dialog")).to_have_count(0)
    (note,) = (await operator.get(NOTES)).json()["notes"]
    assert (note["device"], note["signal"]) == ("base", "turn_rate")
    # Begun at 22:14:20 UTC and ten seconds back: whichever end was first.
    assert (note["from_us"], note["to_us"]) == (NOW + 50_000_000, NOW + 60_000_000)
    # It is a mark on the bar at once, with the stretch that it covers, and leads to its beginning.
    await expect(page.locator("t-time-bar [slot=stretches]")).to_have_count(1)
    await page.get_by_role("button", name="note: The left wheel slips").click()
    await expect(bar.locator("time")).to_contain_text("23:14:10")

    # On the charts it is a mark with its words; in the logbook a line at its moment.
    await page.goto(
        f"{hub.origin}/sites/agv/history?c=base/turn_rate&from={NOW}&to={NOW + 90_000_000}"
    )
    await page.locator("t-marks-lane").get_by_role("button", name="note").hover()
    await expect(page.get_by_role("tooltip")).to_contain_text("The left wheel slips")
    await page.goto(f"{hub.origin}/sites/agv/logbook?text=WET")
    line = page.locator("[data-note]")
    await expect(line).to_have_count(1)
    await line.get_by_role("link", name="Board then").click()
    await expect(bar.locator("time")).to_contain_text("23:14:10")
    assert page.errors == []


async def test_a_stretch_that_is_dragged_on_a_chart_gets_a_note(chromium, hub, gateway) -> None:
    rows = [("base/turn_rate", NOW + second * 1_000_000, second / 100) for second in range(90)]
    await gateway.samples(*rows, live=False)
    page = await sign_in(chromium, hub, "operator")
    address = f"{hub.origin}/sites/agv/history?c=base/turn_rate&from={NOW}&to={NOW + 90_000_000}"
    await page.goto(address)
    await expect(page.locator("t-history-chart canvas").first).to_be_visible()
    await page.get_by_role("button", name="Note a stretch").click()
    plot = page.locator("t-history-chart .u-over, t-history-chart t-chart").first
    box = await plot.bounding_box()
    middle = box["y"] + box["height"] / 2
    await page.mouse.move(box["x"] + box["width"] * 0.4, middle)
    await page.mouse.down()
    await page.mouse.move(box["x"] + box["width"] * 0.6, middle, steps=4)
    await page.mouse.up()
    # What is slotted into a dialog lies beside it in the page.
    dialog = page.locator("t-note-dialog")
    await dialog.get_by_label("Text").fill("A bump")
    await dialog.get_by_role("button", name="Save").click()
    await expect(page.get_by_role("dialog")).to_have_count(0)
    operator = await hub.client("operator")
    (note,) = (await operator.get(NOTES)).json()["notes"]
    assert NOW < note["from_us"] < note["to_us"] < NOW + 90_000_000
    # The window stayed: the stretch was for the note alone.
    assert page.url.endswith(address.rpartition("?")[2])
    assert page.errors == []


async def test_notes_are_searched_changed_and_removed_on_their_page(chromium, hub, gateway) -> None:
    operator = await hub.client("operator")
    for second, text in ((0, "Calm start"), (30, "Storm begins"), (60, "Storm ends")):
        at = NOW + second * 1_000_000
        body = {"device": "base", "signal": "", "from_us": at, "to_us": at, "text": text}
        assert (await operator.post(NOTES, json=body)).status_code == 201
    page = await sign_in(chromium, hub, "operator", to="/sites/agv/notes")
    rows = page.locator("[data-note]")
    await expect(rows).to_have_count(3)
    await page.get_by_label("Words").fill("storm")
    await expect(rows).to_have_count(2)
    await page.get_by_role("textbox", name="To (").fill("2023-11-14 23:13:55")
    await expect(rows).to_have_count(1)
    await page.get_by_role("button", name="Clear").click()
    await expect(rows).to_have_count(3)
    # Somebody else changes it while the dialog is open: who is late is told, and loses no words.
    await rows.first.get_by_role("button", name="Change the note").click()
    # What is slotted into a dialog lies beside it in the page.
    dialog = page.locator("t-note-dialog")
    (newest, *_) = (await operator.get(NOTES)).json()["notes"]
    body = {"device": "base", "signal": "", "text": "Storm is over", "base": 1}
    span = {key: newest[key] for key in ("from_us", "to_us")}
    admin = await hub.client("admin")
    assert (await admin.put(f"{NOTES}/{newest['id']}", json={**body, **span})).status_code == 200
    await expect(rows.first).to_contain_text("Storm is over")
    await dialog.get_by_label("Text").fill("Mine")
    await dialog.get_by_role("button", name="Save").click()
    await expect(dialog.get_by_text("changed meanwhile")).to_be_visible()
    await expect(dialog.get_by_label("Text")).to_have_value("Mine")
    await dialog.get_by_role("button", name="Cancel").click()
    await rows.first.get_by_role("button", name="Remove the note").click()
    await page.get_by_role("button", name="Remove it").click()
    await expect(rows).to_have_count(2)
    await page.set_viewport_size({"width": 390, "height": 844})
    assert await page.evaluate("document.documentElement.scrollWidth") <= 390
    assert await find_violations(page) == []
    # Who has no right there reads none, and is offered to write none.
    guest = await sign_in(chromium, hub, "guest", to="/sites/agv/notes")
    await expect(guest.get_by_text("No notes yet")).to_be_visible()
    assert await guest.get_by_role("button", name="Write a note").count() == 0
    assert page.errors == guest.errors == []


async def test_the_bar_of_the_past_leaves_a_phone_to_the_board(chromium, hub, gateway) -> None:
    page = await sign_in(chromium, hub, "operator")
    await page.set_viewport_size({"width": 390, "height": 844})
    await page.goto(f"{hub.origin}/boards/template:agv?at=2023-11-14T22:14:20Z")
    bar = page.locator("t-time-bar")
    await expect(bar.get_by_role("slider", name="Moment")).to_be_visible()
    await expect(bar.get_by_role("button", name="Play")).to_be_visible()
    await expect(bar.get_by_label("Speed")).to_be_hidden()
    # Where nothing was recorded a line more says so.
    small = await bar.evaluate(
        "bar => bar.offsetHeight - bar.shadowRoot.querySelector('[role=status]').offsetHeight"
    )
    assert small <= 120
    await bar.get_by_role("button", name="More of the bar").click()
    await expect(bar.get_by_label("Speed")).to_be_visible()
    assert await page.evaluate("document.documentElement.scrollWidth") <= 390
    assert await find_violations(page) == []
    assert page.errors == []
