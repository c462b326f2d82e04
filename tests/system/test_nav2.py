"""Goals of Nav2 in a mission and from the hub: progress, result, refusal, and STOP that cancels."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import httpx
import pytest
from patience import PATIENCE_S, until_answered
from shared_trust import usual_trust

from talaia.client import Client

from .conftest import need_ros2
from .stack import PASSWORD, SITE, Process, Stack, finish

pytestmark = pytest.mark.robot

ACTION = """\
geometry_msgs/PoseStamped pose
string behavior_tree
---
uint16 NONE=0
uint16 UNKNOWN=9000
uint16 error_code
string error_msg
---
geometry_msgs/PoseStamped current_pose
builtin_interfaces/Duration navigation_time
builtin_interfaces/Duration estimated_time_remaining
int16 number_of_recoveries
float32 distance_remaining
"""
DESCRIPTION = f"""\
talaia: 1
site: {SITE}
name: Yard
ros2: {{definitions: nav2_ws}}
devices:
  base:
    name: Base
    kind: vehicle
    signals:
      ready: {{name: Ready, source: {{topic: /ready, type: std_msgs/msg/Float64, field: data}}}}
    drive: {{topic: /cmd_vel, max_speed: 0.5, max_turn: 1.0}}
    commands:
      goto:
        name: Go to
        kind: action
        target: /navigate_to_pose
        type: nav2_msgs/action/NavigateToPose
        timeout: 60
        progress: distance_remaining
        progress_end: 0
        fixed: {{pose.header.frame_id: map, pose.pose.orientation.w: 1.0}}
        arguments:
          x: {{type: number, field: pose.pose.position.x, unit: m}}
          y: {{type: number, field: pose.pose.position.y, unit: m, default: 0.0}}
"""
MISSIONS = f"/api/sites/{SITE}/missions"


class Navigated(Stack):
    """A hub and a gateway, and a navigator in place of the robot."""

    def start_robot(self) -> Process:
        path = self.folder / "nav2_ws" / "nav2_msgs" / "action" / "NavigateToPose.action"
        path.parent.mkdir(parents=True)
        path.write_text(ACTION)
        script = Path(__file__).with_name("nav2_robot.py")
        return Process([str(script)], self.folder / "robot.log", self._ros)


@pytest.fixture(scope="module")
def navigated(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Navigated]:
    need_ros2()
    running = Navigated(tmp_path_factory.mktemp("nav2"), DESCRIPTION, {"boss": "admin"})
    try:
        finish(running.ready())
        yield running
    finally:
        running.close()


@pytest.fixture
def boss(navigated: Navigated) -> Iterator[httpx.Client]:
    with httpx.Client(
        base_url=navigated.address,
        headers={"Origin": navigated.address},
        timeout=PATIENCE_S,
        verify=usual_trust(),
    ) as person:
        who = {"name": "boss", "password": PASSWORD}
        person.post("/api/login", json=who).raise_for_status()
        yield person


def start_mission(boss: httpx.Client, *goals: tuple[float, float]) -> None:
    step = {
        "kind": "command", "name": "", "device": "base", "command": "goto",
        "units": {"x": "m", "y": "m"}, "condition": "", "seconds": 0, "goes_on": False,
    }  # fmt: skip
    steps = [{**step, "args": {"x": x, "y": y}} for x, y in goals]
    mission = {"name": "Round", "note": "", "steps": steps, "schedule": None}
    made = boss.post(MISSIONS, json={"mission": mission}).raise_for_status().json()["id"]

    async def begun() -> bool:
        # It begins once the robot was heard.
        answer = await asyncio.to_thread(boss.post, f"{MISSIONS}/{made}/start", json={})
        return answer.status_code == 200

    finish(until_answered(begun))


def run_in(boss: httpx.Client, *states: str) -> dict:
    """Wait for the newest run to be in one of these states."""
    found: dict = {}

    async def ended() -> bool:
        answer = await asyncio.to_thread(boss.get, f"/api/sites/{SITE}/mission-runs")
        runs = answer.raise_for_status().json()["runs"]
        found.update(runs[0] if runs else {})
        assert found.get("state", "running") in {"running", *states}, str(found)
        return found.get("state") in states

    finish(until_answered(ended))
    return found


def test_a_mission_of_nav2_goals_ends_as_the_navigator_says(navigated, boss) -> None:
    assert find_spec("nav2_msgs") is None
    start_mission(boss, (1.5, 0.0), (0.5, 0.0))
    run = run_in(boss, "succeeded")
    assert [step["state"] for step in run["steps"]] == ["succeeded", "succeeded"]
    assert "goal map 1.5 0.0" in navigated.robot.said()
    start_mission(boss, (1.0, -1.0), (0.5, 0.0))
    run = run_in(boss, "failed")
    assert [step["state"] for step in run["steps"]] == ["failed", "waiting"]
    start_mission(boss, (1000.0, 0.0))
    assert [step["state"] for step in run_in(boss, "failed")["steps"]] == ["refused"]


def script_of(boss: httpx.Client, navigated: Navigated) -> Client:
    """What a person's script is, by a token of its own."""
    asked = {
        "name": "a script",
        "ends_us": int((time.time() + 3600) * 1e6),
        "permissions": [{"right": "use", "site": SITE, "device": "*"}],
    }
    token = boss.post("/api/me/tokens", json=asked).raise_for_status().json()["token"]
    return Client(navigated.address, token)


def test_a_goal_tells_how_much_of_the_way_is_behind_it(navigated, boss) -> None:
    shares: list[float] = []
    with script_of(boss, navigated) as client:
        ended = client.call_command(
            f"{SITE}/base/goto",
            {"x": 2.0, "y": 0.0},
            report=lambda told: shares.append(told.progress),
        )
    assert ended.phase == "succeeded"
    assert shares == sorted(shares)
    assert any(0.1 < share < 1 for share in shares)


def test_stop_cancels_the_goal_at_the_navigator_and_ends_the_mission(navigated, boss) -> None:
    with script_of(boss, navigated) as client:
        start_mission(boss, (90.0, 0.0), (0.5, 0.0))
        finish(navigated.robot.says("goal map 90.0 0.0"))
        client.press_stop(f"{SITE}/base")
        finish(navigated.robot.says("cancelled with"))
        run = run_in(boss, "stopped")
    assert [step["state"] for step in run["steps"]] == ["cancelled", "waiting"]
    assert run["why"].startswith("STOP is latched at Base")
    assert "goal map 0.5 0.0" not in navigated.robot.said().partition("goal map 90.0")[2]
