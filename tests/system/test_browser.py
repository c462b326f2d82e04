"""The whole product in a real Chromium: sign in, see charts move, drive, and stop.

What the vehicle did is read from its own log, written with its own clock.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator

import pytest
from patience import PATIENCE_MS, PATIENCE_S
from playwright.sync_api import Browser, BrowserContext, Page, expect

from . import pages
from .conftest import Demo

pytestmark = [pytest.mark.browser, pytest.mark.robot]
ROBOT_STOPS_NS = 500_000_000


@pytest.fixture
def context(browser: Browser) -> Iterator[BrowserContext]:
    opened = browser.new_context(viewport={"width": 1440, "height": 1000})
    opened.set_default_timeout(PATIENCE_MS)
    yield opened
    opened.close()


@pytest.fixture
def elsewhere(browser: Browser) -> Iterator[BrowserContext]:
    """A second person's browser."""
    opened = browser.new_context(viewport={"width": 1440, "height": 1000})
    opened.set_default_timeout(PATIENCE_MS)
    yield opened
    opened.close()


@pytest.fixture
def faults(context: BrowserContext) -> list[str]:
    """What the pages complain of: errors, and breaches of the content security policy."""
    told: list[str] = []
    context.on("weberror", lambda error: told.append(str(error.error)))
    context.on(
        "console",
        lambda line: told.append(line.text) if "Security Policy" in line.text else None,
    )
    return told


def sign_in(context: BrowserContext, demo: Demo, role: str) -> Page:
    """Give a person's page that shows nothing yet."""
    page = context.new_page()
    pages.sign_in_unseen(page, demo, role, demo.passwords[role])
    return page


def actuations(demo: Demo) -> list[dict[str, float]]:
    return [json.loads(line) for line in demo.actuations.read_text().splitlines()]


def until(true: Callable[[], bool], page: Page, seconds: float = PATIENCE_S) -> None:
    """Wait for something outside the page while the page lives on."""
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "it did not happen in time"
        page.wait_for_timeout(60)


def take_control(page: Page, demo: Demo) -> None:
    page.goto(f"{demo.address}/sites/agv/drive")
    page.get_by_role("button", name="Take control").click()
    expect(page.get_by_text("You have control").first).to_be_visible()


def hold_until_it_drives(page: Page, demo: Demo, key: str = "w") -> int:
    known = len(actuations(demo))
    page.keyboard.down(key)
    until(lambda: any(each["v"] > 0.05 for each in actuations(demo)[known:]), page)
    return known


def stopped_after(demo: Demo, known: int, page: Page) -> int:
    """Give the moment (ns, the vehicle's own clock) of its last standstill."""
    until(lambda: actuations(demo)[-1]["v"] == 0 and len(actuations(demo)) > known, page)
    return int(actuations(demo)[-1]["monotonic_ns"])


def test_a_wrong_password_is_told_and_lets_nobody_in(context: BrowserContext, demo: Demo) -> None:
    page = context.new_page()
    page.goto(f"{demo.address}/home")
    page.get_by_label("Name").fill("operator")
    page.get_by_label("Password").fill("not the password")
    page.get_by_role("button", name="Sign in", exact=True).click()
    expect(page.get_by_role("alert").first).to_be_visible()
    page.goto(f"{demo.address}/home")
    expect(page.get_by_label("Password")).to_be_visible()


def test_home_shows_the_site_online_with_values_that_move(
    context: BrowserContext, demo: Demo, faults: list[str]
) -> None:
    page = context.new_page()
    # By the form, once: the other tests are about what comes after it.
    pages.sign_in(page, demo, "operator", demo.passwords["operator"])
    expect(page.get_by_role("heading", name="House vehicle")).to_be_visible()
    expect(page.get_by_text("online").first).to_be_visible()
    expect(page.get_by_text("m/s").first).to_be_visible()
    assert faults == []


def test_charts_are_painted_with_samples_that_are_young(
    context: BrowserContext, demo: Demo, faults: list[str]
) -> None:
    context.add_init_script(
        "window.__painted = {};"
        "window.__talaiaPainted = (address, us) => { (window.__painted[address] ??= []).push(us); }"
    )
    page = sign_in(context, demo, "operator")
    page.goto(f"{demo.address}/sites/agv/live")
    # So tall that these are in sight: the others rest.
    page.set_viewport_size({"width": 1440, "height": 3000})
    wanted = ("base/speed", "base/turn_rate", "sensors/ultrasonic1")
    count = "(each) => (window.__painted[each] ?? []).length"
    until(lambda: all(page.evaluate(count, each) > 10 for each in wanted), page)
    newest = page.evaluate("window.__painted['base/speed'].at(-1)")
    assert abs(time.time() * 1e6 - newest) < 5e6
    assert faults == []


def test_holding_a_key_drives_the_vehicle_and_letting_go_stops_it(
    context: BrowserContext, demo: Demo, faults: list[str]
) -> None:
    page = sign_in(context, demo, "operator")
    take_control(page, demo)
    known = hold_until_it_drives(page, demo)
    page.wait_for_timeout(600)  # so long that without renewal the frames would be refused
    until(lambda: actuations(demo)[-1]["v"] > 0.05, page)
    page.keyboard.up("w")
    released = time.monotonic_ns()
    assert stopped_after(demo, known, page) - released < ROBOT_STOPS_NS
    assert faults == []


def test_closing_the_tab_stops_the_vehicle(
    context: BrowserContext, elsewhere: BrowserContext, demo: Demo
) -> None:
    page = sign_in(context, demo, "operator")
    watcher = sign_in(elsewhere, demo, "admin")
    take_control(page, demo)
    known = hold_until_it_drives(page, demo)
    page.close()
    closed = time.monotonic_ns()
    assert stopped_after(demo, known, watcher) - closed < ROBOT_STOPS_NS
    watcher.goto(f"{demo.address}/sites/agv/drive")
    expect(watcher.get_by_role("button", name="Take control")).to_be_enabled()


def test_two_drivers_cannot_have_one_vehicle(
    context: BrowserContext, elsewhere: BrowserContext, demo: Demo
) -> None:
    first = sign_in(context, demo, "operator")
    take_control(first, demo)
    other = sign_in(elsewhere, demo, "admin")
    other.goto(f"{demo.address}/sites/agv/drive")
    expect(other.get_by_text("operator").first).to_be_visible()
    known = len(actuations(demo))
    other.keyboard.down("w")
    other.wait_for_timeout(500)
    other.keyboard.up("w")
    assert len(actuations(demo)) == known


def test_escape_stops_latches_and_is_released_in_two_steps(
    context: BrowserContext, demo: Demo
) -> None:
    page = sign_in(context, demo, "operator")
    take_control(page, demo)
    hold_until_it_drives(page, demo)
    page.keyboard.press("Escape")
    expect(page.get_by_text("Confirmed by the robot").first).to_be_visible(timeout=PATIENCE_MS)
    until(lambda: actuations(demo)[-1]["v"] == 0, page)
    page.keyboard.up("w")
    known = len([each for each in actuations(demo) if each["v"] != 0])
    page.keyboard.down("w")  # while it is latched nothing moves
    page.wait_for_timeout(400)
    page.keyboard.up("w")
    assert len([each for each in actuations(demo) if each["v"] != 0]) == known
    if page.get_by_role("button", name="Take control").is_visible():
        page.get_by_role("button", name="Take control").click()
    page.get_by_role("button", name="Release STOP…").click()
    page.get_by_role("button", name="Release now").click()
    expect(page.get_by_text("Not latched").first).to_be_visible(timeout=PATIENCE_MS)
    assert len([each for each in actuations(demo) if each["v"] != 0]) == known


def test_a_guest_sees_what_is_public_and_no_actions(context: BrowserContext, demo: Demo) -> None:
    page = sign_in(context, demo, "guest")
    page.goto(f"{demo.address}/sites/agv/live")
    expect(page.get_by_text("Speed").first).to_be_visible()
    expect(page.get_by_text("Voltage")).to_have_count(0)
    page.goto(f"{demo.address}/sites/agv/drive")
    page.wait_for_timeout(1000)
    expect(page.get_by_role("button", name="Take control")).to_have_count(0)
    expect(page.get_by_role("button", name="Send")).to_have_count(0)


def test_history_draws_what_was_driven(context: BrowserContext, demo: Demo) -> None:
    page = sign_in(context, demo, "operator")
    answer = page.request.get(
        f"{demo.address}/api/sites/agv/history?channel=base/speed&width=800"
        f"&from_us={int((time.time() - 600) * 1e6)}&to_us={int(time.time() * 1e6)}"
    )
    (series,) = answer.json()["series"]
    assert max(series["v"]) > 0.05
    assert len(series["v"]) <= 1600
    page.goto(f"{demo.address}/sites/agv/history")
    expect(page.get_by_text("newest shown").first).to_be_visible(timeout=PATIENCE_MS)
    expect(page.locator("canvas").first).to_be_visible()


def test_a_command_is_done_once_and_says_so(context: BrowserContext, demo: Demo) -> None:
    page = sign_in(context, demo, "operator")
    page.goto(f"{demo.address}/sites/agv/drive")
    page.get_by_role("button", name="Send").first.click()
    expect(page.get_by_text("succeeded").first).to_be_visible(timeout=PATIENCE_MS)
    until(lambda: actuations(demo)[-1]["source"] == "wander", page)
    take_control(page, demo)
    hold_until_it_drives(page, demo)  # a hand on the keys wins over wandering
    page.keyboard.up("w")
    until(lambda: actuations(demo)[-1]["v"] == 0, page)


def test_the_history_page_tells_what_happened_and_its_link_opens_the_same_view(
    context: BrowserContext, demo: Demo, faults: list[str]
) -> None:
    page = sign_in(context, demo, "operator")
    page.goto(f"{demo.address}/sites/agv/drive")
    page.get_by_role("button", name="Send").first.click()
    expect(page.get_by_text("succeeded").first).to_be_visible(timeout=PATIENCE_MS)
    page.goto(f"{demo.address}/sites/agv/history?c=base/speed&c=power/voltage&last=300&versus=1")
    marks = page.get_by_role("toolbar", name="Events in the window").get_by_role("button")
    expect(marks.first).to_be_visible(timeout=PATIENCE_MS)
    marks.last.focus()
    expect(page.get_by_role("tooltip")).to_contain_text("by operator")
    page.keyboard.press("Escape")
    expect(page.get_by_role("tooltip")).to_have_count(0)
    page.get_by_role("heading", name="History").click()
    page.keyboard.press("ArrowLeft")
    page.wait_for_url("**from=*")
    page.get_by_role("button", name="Share").click()
    link = page.get_by_label("Link").input_value()
    again = context.new_page()
    again.goto(link)
    expect(again.get_by_text("1 day before")).to_be_visible()
    expect(again.locator("t-history-chart")).to_have_count(2)
    assert again.url == link
    assert "c=base/speed&c=power/voltage" in link
    assert "versus=1" in link
    assert faults == []


def test_an_export_holds_what_was_driven(context: BrowserContext, demo: Demo) -> None:
    page = sign_in(context, demo, "operator")
    page.goto(f"{demo.address}/sites/agv/history?c=base/speed&last=600")
    page.get_by_role("button", name="Export").click()
    with page.expect_download() as waiting:
        page.get_by_role("link", name="CSV spreadsheets").click()
    lines = waiting.value.path().read_text().splitlines()
    assert "base/speed" in lines[0]
    assert len(lines) > 10
