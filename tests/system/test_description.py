"""A person changes the description in a real Chromium, and everything follows without a restart."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from patience import PATIENCE_MS
from playwright.sync_api import Browser, TimeoutError as NotYet, expect

from .conftest import missing
from .pages import picture, visit
from .stack import SITE, Stack, finish

pytestmark = [pytest.mark.robot, pytest.mark.browser]

DESCRIPTION = """\
# A robot that counts.
talaia: 1
site: faults
name: Counter
ros2: {}
devices:
  base:
    name: Base
    signals:
      count:  # ten times a second
        name: Count
        source: {topic: /count, type: std_msgs/msg/Float64, field: data}
      wheel1: {name: Wheel 1, source: {topic: /metric, type: std_msgs/msg/String, name: wheel1}}
"""


class Open(Stack):
    """A stack whose gateway takes changes of what is read."""

    accepts = "readings"


@pytest.fixture
def stack(tmp_path: Path) -> Iterator[Stack]:
    if not __import__("importlib.util").util.find_spec("rclpy"):
        missing("rclpy")
    running = Open(tmp_path, DESCRIPTION, {"boss": "admin", "guest": "guest"})
    try:
        finish(running.ready())
        running.robot.tell("count 10")
        yield running
    finally:
        running.close()


def test_sensor_added_in_the_form_has_a_live_chart_without_reload_and_is_gone_after_going_back(
    stack: Stack, chrome: Browser
) -> None:
    editor = visit(chrome, stack, "boss", path="/admin/description")
    live = editor.context.new_page()
    live.set_default_timeout(PATIENCE_MS)
    live.goto(f"{stack.address}/sites/{SITE}/live")
    expect(live.get_by_role("heading", name="Count")).to_be_visible()
    live.evaluate("window.notReloaded = true")

    expect(editor.get_by_text("version 1, since")).to_be_visible()
    editor.get_by_text("Edit", exact=True).click()
    editor.locator("summary", has_text="Devices").click()
    editor.locator("summary", has_text="base").click()
    editor.locator("summary", has_text="Signals").click()
    editor.get_by_role("button", name="Add to signals").click()
    expect(
        editor.get_by_text("things do not fit").or_(editor.get_by_text("1 thing does"))
    ).to_be_visible()
    picture(editor, "description-form")
    added = editor.locator("details", has=editor.locator("summary", has_text="new_signal")).last
    added.locator("summary", has_text="Source").click()
    added.get_by_label("Topic").fill("/count")
    added.get_by_label("Topic").press("Tab")
    added.get_by_label("Type *").or_(added.get_by_label("Type", exact=True)).last.fill(
        "std_msgs/msg/Float64"
    )
    added.get_by_label("Field", exact=True).fill("data")
    added.get_by_label("Field", exact=True).press("Tab")
    expect(editor.get_by_text("fits together")).to_be_visible()
    editor.get_by_role("button", name="Review and apply").click()
    expect(editor.get_by_label("Preview of Base")).to_be_visible()
    picture(editor, "description-review")
    editor.get_by_role("button", name="Apply", exact=True).click()
    expect(editor.get_by_text("version 2, since")).to_be_visible()

    expect(live.get_by_role("heading", name="New signal")).to_be_visible()
    assert live.evaluate("window.notReloaded")
    written = (stack.folder / "site.yaml").read_text()
    assert written.startswith("# A robot that counts.")
    assert "# ten times a second" in written
    assert stack.gateway.said().count("linked to") == 1
    picture(live, "description-live")

    editor.get_by_text("Versions", exact=True).click()
    editor.get_by_role("button", name="What changed in version 2").click()
    expect(editor.get_by_text("+ added")).to_be_visible()
    picture(editor, "description-versions")
    editor.get_by_role("button", name="Go back to version 1").click()
    editor.get_by_role("button", name="Go back to this one", exact=True).last.click()
    expect(editor.get_by_text("version 3, since")).to_be_visible()
    expect(live.get_by_role("heading", name="New signal")).to_have_count(0)
    assert (stack.folder / "site.yaml").read_text() == DESCRIPTION
    assert stack.gateway.said().count("linked to") == 1


def test_sensor_that_the_robot_begins_to_say_is_offered_at_once_and_added_by_three_clicks(
    stack: Stack, chrome: Browser
) -> None:
    page = visit(chrome, stack, "boss", path=f"/sites/{SITE}/logbook")
    expect(page.get_by_role("heading", name="Logbook")).to_be_visible()
    # The robot has said nothing of it before; the page is open already.
    notice = page.get_by_text("/metric: wheel2 is not in the description")
    for _ in range(20):
        # The gateway may be subscribing anew after the change before, and would not hear the first.
        stack.robot.tell("metric {'name': 'wheel2', 'magnitude': 1.5}")
        with suppress(NotYet):
            notice.wait_for(timeout=5_000)
            break
    expect(notice).to_be_visible()
    picture(page, "new-sensor-logbook")
    page.get_by_role("link", name="Add it").click()
    expect(page.get_by_text("wheel2 of /metric is in the form")).to_be_visible()
    picture(page, "new-sensor-form")
    page.get_by_role("button", name="Review and apply").click()
    expect(page.get_by_label("Preview of Base")).to_be_visible()
    page.get_by_role("button", name="Apply", exact=True).click()
    expect(page.get_by_text("version 2, since")).to_be_visible()
    written = " ".join((stack.folder / "site.yaml").read_text().split())
    assert "source: topic: /metric type: std_msgs/msg/String name: wheel2" in written
    page.goto(f"{stack.address}/sites/{SITE}/live")
    expect(page.get_by_role("heading", name="Wheel2")).to_be_visible()


def test_mistake_in_the_text_is_listed_and_leads_to_its_line(stack: Stack, chrome: Browser) -> None:
    page = visit(chrome, stack, "boss", width=390, height=844, path="/admin/description")
    page.get_by_text("Edit", exact=True).click()
    page.get_by_text("Text", exact=True).click()
    area = page.get_by_label("The description as YAML")
    area.fill(
        DESCRIPTION.replace("        name: Count", "        name: Count\n        decimals: many")
    )
    expect(page.get_by_text("1 thing does not fit")).to_be_visible()
    expect(page.get_by_role("button", name="Review and apply")).to_be_disabled()
    page.get_by_role("button", name="devices.base.signals.count.decimals (line 12)").click()
    chosen = area.evaluate("each => each.value.slice(each.selectionStart, each.selectionEnd)")
    assert chosen == "        decimals: many"
    picture(page, "description-text-phone")
    page.get_by_role("button", name="Undo").click()
    expect(page.get_by_text("nothing changed yet")).to_be_visible()
