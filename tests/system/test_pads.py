"""Pads in a real Chromium push a simulated base sideways and jog its arm.

Nothing stands in for anything: mouse and keys, page, hub, gateway, ROS 2, and the simulated vehicle
with a log of its own. What `talaia init` would find is written down here, which saves a minute.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from patience import PATIENCE_MS
from playwright.sync_api import Browser, Locator, Page, expect

from .conftest import missing, need_ros2
from .pages import picture, seen_after, visit
from .stack import SITE, Process, Stack, finish

pytestmark = [pytest.mark.robot, pytest.mark.browser]

JOINTS = ("shoulder_pan", "shoulder_lift", "elbow")
# Behind the four wheels.
SIGNALS = "".join(
    f"      {name}: {{name: {name.replace('_', ' ').title()}, unit: rad, decimals: 3,"
    f" source: {{topic: /joint_states, type: sensor_msgs/msg/JointState,"
    f' field: "position[{at}]"}}}}\n'
    for at, name in enumerate(JOINTS, 4)
)
HEAD = f"talaia: 1\nsite: {SITE}\nname: Simulated base\nros2: {{}}\ndevices:\n"
HOLONOMIC = (
    HEAD
    + """\
  base:
    name: Base
    kind: vehicle
    drive: {topic: /cmd_vel, max_speed: 0.2, max_sideways: 0.2, max_turn: 0.5}
  arm:
    name: Arm
    drive:
      topic: /arm_velocity_controller/commands
      message: std_msgs/msg/Float64MultiArray
      joints:
"""
    + "".join(
        f"        {name}_joint: {{name: {name.replace('_', ' ').title()}, max_speed: 0.5}}\n"
        for name in JOINTS
    )
    + "    signals:\n"
    + SIGNALS
)


class Mecanum(Stack):
    """A hub, a gateway, and the simulated vehicle on wheels for all directions, with an arm."""

    @property
    def log(self) -> Path:
        return self.folder / "actuations.jsonl"

    def start_robot(self) -> Process:
        words = ["-m", "talaia", "sim", "vehicle", "--no-camera", "--log", str(self.log)]
        words += ["--domain", str(self._world.domain), "--drive", "holonomic", "--arm"]
        return Process(words, self.folder / "robot.log", self._ros)

    def rows(self, after: int = 0) -> list[dict[str, Any]]:
        """What moved it, behind so many lines of its log."""
        lines = self.log.read_text().splitlines(keepends=True)[after:]
        return [json.loads(line) for line in lines if line.endswith("\n")]


@pytest.fixture(scope="module")
def mecanum(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Mecanum]:
    need_ros2()
    if not __import__("importlib.util").util.find_spec("mujoco"):
        missing("mujoco")
    running = Mecanum(tmp_path_factory.mktemp("mecanum"), HOLONOMIC)
    try:
        finish(running.ready())
        yield running
    finally:
        running.close()


@pytest.fixture
def page(mecanum: Mecanum, chrome: Browser) -> Page:
    return visit(chrome, mecanum, "driver", path=f"/sites/{SITE}/drive")


def wait_for(page: Page, condition: Callable[[], object]) -> None:
    seen_after(page, time.monotonic(), condition)


def take_control(page: Page, device: str) -> None:
    page.get_by_role("radio", name=device, exact=True).check(force=True)
    take = page.get_by_role("button", name="Take control")
    expect(take).to_be_visible(timeout=PATIENCE_MS)
    take.click()
    expect(take).to_be_hidden(timeout=PATIENCE_MS)


def press(page: Page, target: Locator, *, right: float = 0.0) -> None:
    """Hold what may be pushed, and push it to a side by so much of its half width."""
    target.scroll_into_view_if_needed()
    box = target.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + right * box["width"] / 2, y, steps=3)


def assert_pushed(page: Page, stack: Mecanum, name: str, sign: int) -> None:
    """Wait for a push that is nothing but ``name``, and let go: it must end in zeros."""
    known = len(stack.rows())

    def pushed() -> bool:
        return any(
            sign * row.get(name, 0) > 0.02 and row["v"] == row["w"] == 0
            for row in stack.rows(known)
        )

    wait_for(page, pushed)


def assert_at_rest(page: Page, stack: Mecanum) -> None:
    def at_rest() -> bool:
        last = stack.rows()[-1]
        return last["v"] == last["w"] == 0 and "lateral" not in last

    wait_for(page, at_rest)


def test_the_sideways_pad_pushes_the_base_by_mouse_and_keys(mecanum: Mecanum, page: Page) -> None:
    take_control(page, "Base")
    # The pad turns the base or moves it to a side, as a person has chosen.
    page.get_by_role("radio", name="Move", exact=True).check(force=True)
    press(page, page.locator("t-pad"), right=-0.6)
    assert_pushed(page, mecanum, "lateral", 1)
    picture(page, "pads-sideways")
    page.mouse.up()
    assert_at_rest(page, mecanum)
    page.keyboard.down("e")
    assert_pushed(page, mecanum, "lateral", -1)
    page.keyboard.up("e")
    assert_at_rest(page, mecanum)


def test_a_joint_moves_while_its_button_is_held_and_stands_when_it_is_let_go(
    mecanum: Mecanum, page: Page
) -> None:
    take_control(page, "Arm")
    lift = page.get_by_role("button", name="Shoulder Lift, up")
    begun = joint_of(mecanum, page, "shoulder_lift")
    press(page, lift)
    wait_for(page, lambda: joint_of(mecanum, page, "shoulder_lift") > begun + 0.1)
    picture(page, "pads-jog")
    page.mouse.up()
    places: list[tuple[float, float]] = []

    def stands() -> bool:
        # Readings of the robot a second apart, whenever the hub has written them.
        places.append(reading_of(mecanum, page, "shoulder_lift"))
        newest_s, newest = places[-1]
        return any(newest_s - then_s > 1 and abs(newest - then) < 0.001 for then_s, then in places)

    wait_for(page, stands)
    assert abs(joint_of(mecanum, page, "shoulder_pan")) < 0.01


def joint_of(stack: Stack, page: Page, name: str) -> float:
    """Ask the hub where the simulator says that a joint stands (rad)."""
    return reading_of(stack, page, name)[1]


def reading_of(stack: Stack, page: Page, name: str) -> tuple[float, float]:
    """Give when a joint was read last (s), and where it stood (rad)."""
    answer = page.context.request.get(
        f"{stack.address}/api/sites/{SITE}/last",
        params={"channel": f"arm/{name}", "before_us": str(time.time_ns() // 1000)},
    )
    assert answer.ok, answer.text()
    (found,) = answer.json()["values"]
    return found["t_us"] / 1e6, float(found["v"])
