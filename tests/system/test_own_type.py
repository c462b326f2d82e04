"""Types that no package here knows: seen, charted, recorded and called, by real processes."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path

import httpx
import pytest
from patience import PATIENCE_MS, PATIENCE_S
from playwright.sync_api import Browser, expect
from rosbags.highlevel import AnyReader
from shared_trust import usual_trust

from talaia.client import Client

from .conftest import need_ros2
from .pages import picture, visit
from .stack import PASSWORD, SITE, Process, Stack, finish, until

pytestmark = [pytest.mark.robot, pytest.mark.browser]

PACKAGE = "oven_own_msgs"
# What the gateway cannot ask a robot for; the messages it can.
OWN_FILES = {
    "msg/Shelf.msg": "uint8 number\nfloat64 celsius\n",
    "srv/Preheat.srv": f"{PACKAGE}/Shelf shelf\n---\nbool success\nstring message\n",
}
DESCRIPTION = f"""\
talaia: 1
site: {SITE}
name: Kitchen
ros2: {{definitions: own_ws}}
recording: {{topics: [/oven/bake], before: 600, upload: 5000, triggers: []}}
devices:
  oven:
    name: Oven
    signals:
      shelf:
        name: Upper shelf
        unit: °C
        source:
          {{topic: /oven/bake, type: {PACKAGE}/msg/Bake, field: "shelves[1].celsius"}}
    commands:
      preheat:
        name: Preheat
        target: /oven/preheat
        type: {PACKAGE}/srv/Preheat
        fixed: {{shelf.number: 2}}
        arguments: {{heat: {{type: number, field: shelf.celsius, minimum: 0, maximum: 1000}}}}
      order:
        name: Order
        kind: topic
        target: /oven/orders
        type: {PACKAGE}/msg/Order
        arguments:
          guest: {{type: text, field: guest}}
          heat: {{type: number, field: "shelves[1].celsius", minimum: 0, maximum: 1000}}
"""
SHELF = "oven/shelf"
NOTE_PAINTED = (
    "window.__painted = {};"
    "window.__talaiaPainted = (address, us) => { (window.__painted[address] ??= []).push(us); }"
)


class Kitchen(Stack):
    """A hub and a gateway, and an oven in place of the robot."""

    def start_robot(self) -> Process:
        workspace = self.folder / "own_ws"
        for name, text in OWN_FILES.items():
            path = workspace / PACKAGE / name
            path.parent.mkdir(parents=True)
            path.write_text(text)
        script = Path(__file__).with_name("own_type_robot.py")
        return Process([str(script), str(workspace)], self.folder / "robot.log", self._ros)


@pytest.fixture(scope="module")
def kitchen(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Kitchen]:
    need_ros2()
    running = Kitchen(tmp_path_factory.mktemp("kitchen"), DESCRIPTION, {"boss": "admin"})
    try:
        finish(running.ready())
        yield running
    finally:
        running.close()


@pytest.fixture
def script(kitchen: Kitchen) -> Iterator[Client]:
    """What people write in Python, by a token of its own."""
    address = kitchen.address
    with httpx.Client(
        base_url=address, headers={"Origin": address}, timeout=PATIENCE_S, verify=usual_trust()
    ) as person:
        who = {"name": "boss", "password": PASSWORD}
        person.post("/api/login", json=who).raise_for_status()
        asked = {
            "name": "a script",
            "ends_us": int((time.time() + 3600) * 1e6),
            "permissions": [{"right": "use", "site": SITE, "device": "*"}],
        }
        token = person.post("/api/me/tokens", json=asked).raise_for_status().json()["token"]
    with Client(address, token) as client:
        yield client


def bake(kitchen: Kitchen, script: Client, *degrees: float) -> None:
    """Publish values; each when the one before has come all the way."""
    for value in degrees:
        kitchen.robot.tell(str(value))
        for reading in script.watch_values([f"{SITE}/{SHELF}"], every_s=0.0):
            if reading.value == value:
                assert (reading.unit, reading.stale) == ("°C", "")
                break


def wait_for(condition: Callable[[], object], what: str) -> None:
    async def come() -> None:
        await until(condition, what=what)

    finish(come())


def test_own_type_of_a_robot_is_seen_live_and_charted(
    kitchen: Kitchen, script: Client, chrome: Browser
) -> None:
    assert find_spec(PACKAGE) is None
    began = time.time()
    page = visit(chrome, kitchen, "boss", scripts=[NOTE_PAINTED], path=f"/sites/{SITE}/live")
    painted = f"(window.__painted['{SHELF}'] ?? []).length"
    for count, value in enumerate((187.5, 201.5), 1):
        bake(kitchen, script, value)
        reading = page.locator("t-chart-tile", has_text="Upper shelf").locator(".reading")
        expect(reading).to_contain_text(str(value), timeout=PATIENCE_MS)
        # A function: the page's policy lets nobody evaluate an expression a second time.
        page.wait_for_function(f"() => {painted} >= {count}", timeout=PATIENCE_MS)
    picture(page, "own-type")

    def kept() -> bool:
        # Committed some moments after it was seen.
        column = script.read_history([f"{SITE}/{SHELF}"], since=began).column(SHELF)
        return [value for value in column.to_pylist() if value is not None] == [187.5, 201.5]

    wait_for(kept, "both in the history")


def test_own_type_is_recorded_with_the_definition_that_others_read_it_by(
    kitchen: Kitchen, script: Client, tmp_path: Path
) -> None:
    script.start_recording(SITE, why="bread")
    bake(kitchen, script, 99.5, 100.75)
    script.stop_recording(SITE)
    wait_for(lambda: script.list_recordings(SITE).recordings, "a recording")
    number = script.list_recordings(SITE).recordings[0].id
    whole = script.wait_recording(SITE, number, timeout_s=PATIENCE_S)
    path = tmp_path / "oven.mcap"
    assert script.download_recording(SITE, whole.id, path) == whole.size
    with AnyReader([path]) as reader:
        assert {each.msgtype for each in reader.connections} == {f"{PACKAGE}/msg/Bake"}
        baked = [
            reader.deserialize(data, connection.msgtype)
            for connection, _, data in reader.messages()
        ]
    assert [each.shelves[1].celsius for each in baked][-2:] == [99.5, 100.75]
    assert (baked[-1].recipe, baked[-1].shelves[0].number, baked[-1].minutes) == ("bread", 1, 40)


def test_a_service_of_an_own_type_is_called_and_its_answer_read(
    kitchen: Kitchen, script: Client
) -> None:
    done = script.call_command(f"{SITE}/oven/preheat", {"heat": 180.5}, timeout_s=PATIENCE_S)
    assert (done.phase, done.message) == ("succeeded", "shelf 2 glows")
    done = script.call_command(f"{SITE}/oven/preheat", {"heat": 900}, timeout_s=PATIENCE_S)
    assert (done.phase, done.message) == ("failed", "shelf 2 melts")
    assert "preheated 2 180.5" in kitchen.robot.said()


def test_a_message_of_an_own_type_is_published_to_the_robot(
    kitchen: Kitchen, script: Client
) -> None:
    asked = {"guest": "Zoë", "heat": 60.25}
    done = script.call_command(f"{SITE}/oven/order", asked, timeout_s=PATIENCE_S)
    assert (done.phase, done.message) == ("succeeded", "published")
    wait_for(lambda: "ordered Zoë 0:0.0 0:60.25" in kitchen.robot.said(), "the order")
