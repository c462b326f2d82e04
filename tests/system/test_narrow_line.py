"""A camera over a line that is far too narrow, judged by the pixels that are drawn."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser
from ports import free_port

from .conftest import missing
from .faults.proxy import Proxy
from .faults.weather import Weather
from .pages import visit
from .stack import SITE, Process, Stack, finish

pytestmark = [pytest.mark.robot, pytest.mark.browser]

DESCRIPTION = """
talaia: 1
site: faults
name: Narrow
ros2: {}
devices:
  eyes:
    name: Eyes
    streams:
      busy: {name: busy, source: {topic: /cam/busy, type: sensor_msgs/msg/Image}}
"""
# Spread of brightness of each picture that the page calls live, from a few of its pixels.
SPREADS = """
window.__spreads = [];
const small = new OffscreenCanvas(32, 24).getContext("2d", {willReadFrequently: true});
const canvasIn = root => {
  for (const each of root.querySelectorAll("*")) {
    if (each.tagName === "CANVAS") return each;
    const inner = each.shadowRoot && canvasIn(each.shadowRoot);
    if (inner) return inner;
  }
  return null;
};
window.__talaiaPictured = (timeUs, format) => requestAnimationFrame(() => {
  const canvas = canvasIn(document);
  if (canvas === null) return;
  small.drawImage(canvas, 0, 0, 32, 24);
  const data = small.getImageData(0, 0, 32, 24).data;
  const light = [...Array(32 * 24).keys()].map(at => data[4 * at + 1]);
  const mean = light.reduce((a, b) => a + b) / light.length;
  const spread = Math.sqrt(light.reduce((a, b) => a + (b - mean) ** 2, 0) / light.length);
  window.__spreads.push([format, spread]);
});
window.__drawn = many => new Promise(done => {
  const look = () => (window.__spreads.length >= many ? done(true) : requestAnimationFrame(look));
  look();
});
"""
# B/s: 64 kbit/s, where this scene at full rate takes ten times as much.
NARROW = 8_000


class NarrowStack(Stack):
    """A site whose gateway dials through a proxy."""

    chosen = 0

    def _free_port(self) -> int:
        return type(self).chosen


@pytest.fixture
def line(tmp_path: Path) -> Iterator[tuple[NarrowStack, Proxy]]:
    for module in ("rclpy", "av"):
        if not __import__("importlib.util").util.find_spec(module):
            missing(module)
    NarrowStack.chosen = free_port()
    proxy = Proxy(NarrowStack.chosen)
    running = NarrowStack(tmp_path, DESCRIPTION, {"boss": "admin"}, link_port=proxy.port)
    robot = Process(
        [str(Path(__file__).parent / "narrow_robot.py")], tmp_path / "robot2.log", running._ros
    )
    try:
        finish(running.ready())
        finish(robot.says("ready"))
        yield running, proxy
    finally:
        robot.end()
        running.close()
        proxy.close()


def test_on_a_congested_line_no_picture_that_is_called_live_is_a_grey_area(
    line: tuple[NarrowStack, Proxy], chrome: Browser
) -> None:
    stack, proxy = line
    path = f"/sites/{SITE}/devices/eyes"
    page = visit(chrome, stack, "boss", scripts=(SPREADS,), path=path)
    page.evaluate("window.__drawn(20)")
    usual = sorted(spread for _, spread in page.evaluate("window.__spreads"))[10]
    proxy.change(Weather(rate=NARROW))
    # The gateway takes its time to find the line full, and each step down shows.
    page.evaluate("window.__spreads = []")
    page.evaluate("window.__drawn(60)")
    shown = page.evaluate("window.__spreads")
    assert {form for form, _ in shown} <= {"h264", "jpeg"}
    grey = [spread for _, spread in shown if spread < 0.3 * usual]
    assert grey == []
