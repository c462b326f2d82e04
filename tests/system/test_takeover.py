"""Two people in two browsers want to drive the same vehicle."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator

import pytest
from patience import PATIENCE_MS
from playwright.sync_api import Browser, Page, expect

from .conftest import Demo
from .pages import picture
from .test_browser import hold_until_it_drives, sign_in, take_control, until

pytestmark = [pytest.mark.browser, pytest.mark.robot]
ASKED = re.compile(r"admin asks for control")


@pytest.fixture
def pages(browser: Browser, demo: Demo) -> Iterator[tuple[Page, Page]]:
    """The operator's page, who has control, and the admin's beside it."""
    contexts = [browser.new_context(viewport={"width": 1280, "height": 1000}) for _ in range(2)]
    for context in contexts:
        context.set_default_timeout(PATIENCE_MS)
    operator = sign_in(contexts[0], demo, "operator")
    admin = sign_in(contexts[1], demo, "admin")
    take_control(operator, demo)
    admin.goto(f"{demo.address}/sites/agv/drive")
    expect(admin.get_by_text("operator has control").first).to_be_visible()
    yield operator, admin
    for context in contexts:
        context.close()


def velocities(demo: Demo) -> list[float]:
    return [json.loads(line)["v"] for line in demo.actuations.read_text().splitlines()]


def test_handing_over_stops_the_vehicle_before_the_other_drives(
    pages: tuple[Page, Page], demo: Demo
) -> None:
    operator, admin = pages
    known = hold_until_it_drives(operator, demo)
    admin.get_by_role("button", name="Ask for control").click()
    expect(admin.get_by_text("operator is asked").first).to_be_visible()
    expect(operator.get_by_role("alert").filter(has_text=ASKED)).to_be_visible()
    expect(operator.get_by_text(re.compile(r"[1-5]\ss to answer"))).to_be_visible()
    picture(operator, "takeover-holder")
    picture(admin, "takeover-asker")
    # The ask alone changes nothing: the holder drives on, once a busy machine lets frames through.
    until(lambda: velocities(demo)[-1] > 0, operator)
    operator.get_by_role("button", name="Hand over").click()
    expect(admin.get_by_text("You have control").first).to_be_visible()
    expect(operator.get_by_text("You handed control to admin.")).to_be_visible()
    # The former driver still holds the key down.
    until(lambda: velocities(demo)[-1] == 0, admin)
    operator.keyboard.up("w")
    admin.bring_to_front()
    stood = len(velocities(demo))
    hold_until_it_drives(admin, demo)
    admin.keyboard.up("w")
    assert 0.0 in velocities(demo)[known:stood]


def test_keeping_control_is_told_and_an_operator_may_not_force(
    pages: tuple[Page, Page], demo: Demo
) -> None:
    operator, admin = pages
    operator.get_by_role("button", name="Release control").click()
    admin.get_by_role("button", name="Take control").click()
    operator.get_by_role("button", name="Ask for control").click()
    admin.get_by_role("button", name="Keep").click()
    expect(operator.get_by_text("admin keeps control")).to_be_visible()
    expect(operator.get_by_role("button", name="Ask for control")).to_be_visible()
    expect(operator.get_by_role("button", name="Take by force")).to_have_count(0)


def test_an_admin_forces_control_from_who_does_not_answer(
    pages: tuple[Page, Page], demo: Demo
) -> None:
    operator, admin = pages
    hold_until_it_drives(operator, demo)
    admin.get_by_role("button", name="Ask for control").click()
    expect(admin.get_by_text("operator has not answered")).to_be_visible()
    picture(admin, "takeover-force")
    admin.get_by_role("button", name="Take by force").click()
    expect(admin.get_by_text("You have control").first).to_be_visible()
    expect(operator.get_by_text("admin has control now.")).to_be_visible()
    until(lambda: velocities(demo)[-1] == 0, admin)
    picture(operator, "takeover-lost")
