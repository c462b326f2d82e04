"""Two robot protocols in one site, as a person sees them: one is lost, and the other goes on."""

from __future__ import annotations

import contextlib
import subprocess
import time
import xmlrpc.client
from collections.abc import Iterator
from pathlib import Path

import pytest
from patience import PATIENCE_MS, PATIENCE_S
from playwright.sync_api import Browser, Page as BrowserPage, expect
from ports import free_port

from .conftest import missing
from .pages import picture, seen_after, visit
from .stack import SITE, Stack, finish

pytestmark = [pytest.mark.robot, pytest.mark.browser]

PYTHON, ROSMASTER = "/usr/bin/python3", "/usr/bin/rosmaster"
DESCRIPTION = """\
talaia: 1
site: faults
name: Two sides
connections:
  new: {kind: ros2}
  old: {kind: ros1, master: "http://127.0.0.1:%d"}
devices:
  base:
    name: Base
    connection: new
    signals:
      wheel1: {name: Speed, source: {topic: /metric, type: std_msgs/msg/String, name: wheel1}}
  tank:
    name: Tank
    connection: old
    signals:
      level:
        name: Level
        unit: m
        max_age: 60
        source: {topic: /level, type: std_msgs/msg/Float64, field: data}
"""
NODE = """
import rospy
from std_msgs.msg import Float64
rospy.init_node("tank", disable_signals=True)
said = rospy.Publisher("/level", Float64, queue_size=1)
while True:
    said.publish(Float64(1.25))
    rospy.sleep(0.1)
"""


class Ros1:
    """A master and a node of Debian's, that are started and killed together."""

    def __init__(self, home: Path) -> None:  # noqa: D107
        self.port = free_port()
        self.uri = f"http://127.0.0.1:{self.port}"
        self._environment = {
            "PATH": "/usr/bin:/bin", "ROS_MASTER_URI": self.uri, "ROS_IP": "127.0.0.1",
            "ROS_HOME": str(home), "HOME": str(home),
        }  # fmt: skip
        self._running: list[subprocess.Popen[bytes]] = []

    def start(self) -> None:
        self._run(ROSMASTER, "--core", "-p", str(self.port))
        until = time.monotonic() + PATIENCE_S
        while True:
            with contextlib.suppress(OSError), xmlrpc.client.ServerProxy(self.uri) as proxy:
                proxy.getPid("/test")
                break
            assert time.monotonic() < until, "rosmaster does not answer"
        self._run("-c", NODE)

    def _run(self, *words: str) -> None:
        self._running.append(
            subprocess.Popen([PYTHON, *words], env=self._environment, stdout=subprocess.DEVNULL)
        )

    def kill(self) -> None:
        for process in self._running:
            process.kill()
            process.wait()
        self._running.clear()


@pytest.fixture
def ros1(tmp_path: Path) -> Iterator[Ros1]:
    if not Path(ROSMASTER).exists() or not Path("/usr/lib/python3/dist-packages/rospy").exists():
        missing("ROS 1 (python3-rospy, python3-rosmaster)")
    one = Ros1(tmp_path)
    one.start()
    yield one
    one.kill()


@pytest.fixture
def stack(ros1: Ros1, tmp_path: Path) -> Iterator[Stack]:
    for module in ("rclpy", "mujoco"):
        if not __import__("importlib.util").util.find_spec(module):
            missing(module)
    folder = tmp_path / "stack"
    folder.mkdir()
    running = Stack(folder, DESCRIPTION % ros1.port, {"boss": "admin"})
    try:
        finish(running.ready())
        yield running
    finally:
        running.close()


@pytest.fixture
def shown(chrome: Browser, stack: Stack) -> BrowserPage:
    return visit(chrome, stack, "boss")


def test_a_lost_robot_is_unknown_within_two_seconds_and_the_other_goes_on(
    shown: BrowserPage, stack: Stack, ros1: Ros1
) -> None:
    shown.goto(f"{stack.address}/sites/{SITE}/devices/tank")
    level = shown.locator("t-chart-tile", has_text="Level")
    expect(level).to_contain_text("1.25", timeout=PATIENCE_MS)
    status = level.locator("t-status")
    lost = time.monotonic()
    ros1.kill()
    # By a locator's filter, which sees what is in an element's shadow, too.
    took = seen_after(shown, lost, lambda: status.filter(has_text="not reached").count())
    # Its values may be a minute old by the description, and yet.
    assert took < 2.0
    where = shown.locator(".where")
    expect(where).to_contain_text("no ROS master answers")
    expect(level.locator("t-value").first).to_have_text("–")
    picture(shown, "not-reached-desktop")
    shown.set_viewport_size({"width": 390, "height": 844})
    picture(shown, "not-reached-phone")
    shown.emulate_media(color_scheme="dark")
    picture(shown, "not-reached-phone-dark")
    shown.set_viewport_size({"width": 1440, "height": 900})
    shown.emulate_media(color_scheme="light")
    shown.goto(f"{stack.address}/devices")
    tank, base = (
        shown.locator("a.device", has=shown.get_by_role("heading", name=name))
        for name in ("Tank", "Base")
    )
    expect(tank.locator("t-status")).to_have_text("not reached")
    expect(base.locator("t-status")).not_to_have_text("not reached")
    picture(shown, "not-reached-devices")
    ros1.start()
    shown.goto(f"{stack.address}/sites/{SITE}/devices/tank")
    expect(level.locator("t-status")).to_have_text("live", timeout=PATIENCE_MS)
    expect(level).to_contain_text("1.25")
