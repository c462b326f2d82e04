"""Raw topics on our own pages: a robot's own type and its diagnostics, by real processes."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from patience import PATIENCE_MS
from playwright.sync_api import Browser, Locator, Page, expect

from .conftest import need_ros2
from .pages import picture, visit
from .stack import SITE, Process, Stack, finish, until
from .test_own_type import OWN_FILES, PACKAGE

pytestmark = [pytest.mark.robot, pytest.mark.browser]

DESCRIPTION = f"""\
talaia: 1
site: {SITE}
name: Kitchen
ros2: {{definitions: own_ws}}
devices:
  oven: {{name: Oven}}
topics:
  - {{pattern: /diagnostics, right: view}}
  - {{pattern: /oven/bake, right: view, device: oven}}
"""
STATUSES = [
    ["oven: heater", 0, "warm", {"power": "1.2 kW"}],
    ["oven: door", 1, "not quite shut", {"gap": "3 mm"}],
    ["/Kitchen/Fan/left", 2, "stands still", {"speed": "0 rpm", "current": "4.1 A"}],
]


class Kitchen(Stack):
    """A hub and a gateway, an oven with types of its own, and a node with diagnostics."""

    accepts = "readings"

    def start_robot(self) -> Process:
        workspace = self.folder / "own_ws"
        for name, text in OWN_FILES.items():
            path = workspace / PACKAGE / name
            path.parent.mkdir(parents=True)
            path.write_text(text)
        here = Path(__file__).parent
        words = [str(here / "diagnostics_robot.py")]
        self.diagnostics = Process(words, self.folder / "diagnostics.log", self._ros)
        words = [str(here / "own_type_robot.py"), str(workspace)]
        return Process(words, self.folder / "robot.log", self._ros)

    def close(self) -> None:
        self.diagnostics.end()
        super().close()


@pytest.fixture(scope="module")
def kitchen(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Kitchen]:
    need_ros2()
    people = {"cook": "operator", "guest": "guest", "chef": "admin"}
    running = Kitchen(tmp_path_factory.mktemp("kitchen"), DESCRIPTION, people)
    try:
        finish(running.ready())
        finish(running.diagnostics.says("ready"))
        yield running
    finally:
        running.close()


def diagnose(kitchen: Kitchen, *statuses: list[object]) -> None:
    kitchen.diagnostics.tell(json.dumps(list(statuses)))


def last_count(kitchen: Kitchen) -> int:
    """Give how many hear the robot's diagnostics, as it knows it."""
    counts = re.findall(r"heard by (\d+)\n", kitchen.diagnostics.said())
    return int(counts[-1]) if counts else -1


def node(page: Page, path: str) -> Locator:
    return page.locator(f"t-diagnostics li[data-path='{path}']")


def test_own_type_is_seen_as_a_tree_searched_and_paused(kitchen: Kitchen, chrome: Browser) -> None:
    page = visit(chrome, kitchen, "cook", path=f"/sites/{SITE}/topics")
    row = page.get_by_role("link", name="/oven/bake")
    expect(row).to_contain_text("who may view Oven")
    row.click()
    expect(page.locator("t-topic")).to_contain_text("No message yet")
    kitchen.robot.tell("187.5")
    tree = page.locator("t-message-tree")
    expect(tree).to_contain_text('"bread"')
    page.get_by_label("Search a field by its path").fill("shelves[1].celsius")
    found = tree.locator("li[data-path='shelves[1].celsius']")
    expect(found).to_contain_text("187.5")
    expect(tree.locator("li[data-path='recipe']")).to_have_count(0)
    picture(page, "topic-own-type")
    page.get_by_role("button", name="Pause").click()
    kitchen.robot.tell("201.5")
    expect(page.locator("t-topic")).to_contain_text("1 newer message has come")
    expect(found).to_contain_text("187.5")
    page.get_by_role("button", name="Resume").click()
    expect(found).to_contain_text("201.5")
    # Drawn over time from then on.
    page.get_by_role("button", name="Plot shelves[1].celsius", exact=True).click()
    kitchen.robot.tell("210.5")
    expect(page.locator("t-field-plot li")).to_contain_text("210.5")


def test_an_admin_makes_a_signal_of_a_field_and_its_next_value_is_on_the_site_s_page(
    kitchen: Kitchen, chrome: Browser
) -> None:
    path = f"/sites/{SITE}/topics?topic=/oven/bake"
    page = visit(chrome, kitchen, "cook", path=path)
    kitchen.robot.tell("187.5")
    # Only who may change the description is offered it.
    expect(page.get_by_role("button", name="Plot shelves[1].celsius", exact=True)).to_be_visible()
    expect(page.get_by_role("button", name="Make shelves[1].celsius a signal")).to_have_count(0)
    page.close()
    page = visit(chrome, kitchen, "chef", path=path)
    kitchen.robot.tell("187.5")
    offered = page.get_by_role("button", name="Make shelves[1].celsius a signal")
    offered.click()
    dialog = page.locator("t-signal-dialog")
    expect(dialog.get_by_label("Name")).to_have_value("Shelves 1 celsius")
    picture(page, "topic-make-signal")
    dialog.get_by_label("Name").fill("Lower shelf")
    dialog.get_by_label("Unit").fill("K")
    dialog.get_by_role("button", name="Review").click()
    expect(dialog.locator("t-difference")).to_contain_text("Lower shelf")
    # Back to what was written.
    dialog.get_by_role("button", name="Back").click()
    expect(dialog.get_by_label("Name")).to_have_value("Lower shelf")
    dialog.get_by_label("Unit").fill("°C")
    dialog.get_by_role("button", name="Review").click()
    expect(dialog.locator("t-difference")).to_contain_text("Lower shelf")
    picture(page, "topic-make-signal-review")
    dialog.get_by_role("button", name="Apply").click()
    expect(dialog).to_contain_text("The gateway has it")
    dialog.get_by_role("button", name="Close").click()
    offered.click()
    expect(dialog).to_contain_text("It is called Lower shelf")
    page.goto(f"{kitchen.address}/sites/{SITE}/live")
    expect(page.get_by_text("Lower shelf").first).to_be_visible()
    kitchen.robot.tell("203.5")
    picture(page, "topic-made-signal")
    expect(page.locator("t-page-live")).to_contain_text("203.5")
    # As a board's tile leads to it.
    page.goto(f"{kitchen.address}{path}&signal=shelves[1].number")
    expect(dialog.get_by_label("Name")).to_have_value("Shelves 1 number")
    page.close()


def test_diagnostics_are_a_tree_that_grows_stale_and_is_heard_only_while_looked_at(
    kitchen: Kitchen, chrome: Browser
) -> None:
    finish(until(lambda: last_count(kitchen) == 0, what="nobody hears it"))
    # Offered by the description: on the site's own page, too.
    page = visit(chrome, kitchen, "cook", path=f"/sites/{SITE}/live")
    finish(until(lambda: last_count(kitchen) == 1, what="it is heard once for all"))
    # Said again until it is heard: that it is subscribed is not known everywhere at once.
    while not node(page, "oven").count():
        diagnose(kitchen, *STATUSES)
        page.wait_for_timeout(200)
    expect(page.locator("t-diagnostics .counts")).to_contain_text("1 ERROR")
    # What is in trouble is open; what is fine is not.
    expect(node(page, "Kitchen/Fan/left")).to_contain_text("stands still")
    expect(node(page, "oven/door")).to_contain_text("WARN")
    node(page, "Kitchen/Fan/left").get_by_role("button").click()
    expect(node(page, "Kitchen/Fan/left")).to_contain_text("4.1 A")
    picture(page, "topic-diagnostics-tile")
    followed: list[str] = []
    page.on("websocket", lambda one: followed.append(one.url) if "/ws/topic" in one.url else None)
    page.goto(f"{kitchen.address}/sites/{SITE}/topics?topic=/diagnostics")
    # Said again until it is heard: the page has only just asked for it.
    while not node(page, "oven").count():
        diagnose(kitchen, *STATUSES[:2])
        page.wait_for_timeout(200)
    # What nobody says again is stale; what this page did not hear yet is not there.
    expect(node(page, "oven")).to_have_attribute("data-level", "warn", timeout=PATIENCE_MS)
    expect(node(page, "Kitchen")).to_have_count(0)
    # The page's own facts and the tree within it.
    assert len(followed) == 1
    expect(node(page, "oven")).to_have_attribute("data-level", "stale", timeout=PATIENCE_MS)
    picture(page, "topic-diagnostics-stale")
    page.close()
    # Once it was let go before that, when the page changed, unless the next one was quicker.
    finish(until(lambda: last_count(kitchen) == 0, what="the robot is let rest"))


def test_who_may_not_view_it_is_told_so_and_hears_nothing(
    kitchen: Kitchen, chrome: Browser
) -> None:
    page = visit(chrome, kitchen, "guest", path=f"/sites/{SITE}/topics?topic=/diagnostics")
    expect(page.locator("t-page-topics")).to_contain_text("There is no", timeout=PATIENCE_MS)
    expect(page.locator("t-topic")).to_have_count(0)
