"""What a person sees and does in a real Chromium when something is pulled out.

The vehicle is a robot of the tests, over real ROS 2; what reached it is read from its own log. The
gamepad is none: Chromium has no way to plug one in, so the page's own reading of it is given one.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from patience import PATIENCE_MS, PATIENCE_S
from playwright.sync_api import Browser, Locator, Page, expect

from .conftest import missing
from .faults.proxy import Proxy
from .faults.weather import Way, Weather
from .pages import picture, visit
from .stack import SITE, Process, Stack, finish

pytestmark = [pytest.mark.robot, pytest.mark.browser]

DESCRIPTION = """\
talaia: 1
site: faults
name: By hand
ros2: {}
devices:
  base:
    name: Base
    kind: vehicle
    signals:
      count:
        name: Count
        max_age: 1
        source: {topic: /count, type: std_msgs/msg/Float64, field: data}
      still: {name: Still, source: {topic: /still, type: std_msgs/msg/Float64, field: data}}
      tilt:
        name: Tilt
        unit: °
        max_age: 600
        source: {topic: /metric, type: std_msgs/msg/String, name: tilt}
    commands:
      survey:
        name: Survey
        kind: action
        target: /survey
        type: test_msgs/action/Fibonacci
        progress: sequence[0]
        progress_end: 100
        arguments:
          time: {type: integer, field: order, unit: s, minimum: 1, maximum: 60, default: 20}
      beep: {name: Beep, kind: topic, target: /control, type: std_msgs/msg/String, fixed: {data: b}}
    drive:
      topic: /cmd_vel
      max_speed: 0.5
      max_turn: 1.0
      max_acceleration: 1000
      max_turn_acceleration: 1000
      stop: {topic: /stop, confirmed_by: [base/still]}
interlocks:
  slope:
    name: Too steep
    when: [{signal: base/tilt, above: 20}]
    refuse: [base/drive, base/beep]
    dwell: 1
"""
STOPPED_NS = 500_000_000
RESTS_NS = 300_000_000
DARK = Weather(dark=frozenset(Way))
# How a driving frame of the hub begins: its tag, as MessagePack has it.
DRIVING_FRAME = b"\xa5drive"


class Plugged(Stack):
    """A stack with a cable between gateway and hub that can be pulled."""

    def __init__(self, folder: Path) -> None:  # noqa: D107
        self.port = Stack._free_port(self)
        self.cable = Proxy(self.port)
        people = {"driver": "operator", "boss": "admin"}
        super().__init__(folder, DESCRIPTION, people, self.cable.port)
        words = [str(Path(__file__).parent / "actor.py")]
        self.actor = Process(words, folder / "actor.log", self._ros)

    def _free_port(self) -> int:
        return self.port

    def close(self) -> None:
        self.actor.end()
        super().close()
        self.cable.close()


@pytest.fixture(scope="module")
def plugged(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Plugged]:
    for module in ("rclpy", "mujoco"):
        if not __import__("importlib.util").util.find_spec(module):
            missing(module)
    running = Plugged(tmp_path_factory.mktemp("by-hand"))
    try:
        finish(running.ready())
        finish(running.actor.says("ready"))
        running.robot.tell("count 50")
        yield running
    finally:
        running.close()


def until(
    true: Callable[[], object], page: Page, seconds: float = PATIENCE_S, what: str = ""
) -> None:
    """Wait for something outside the page while the page lives on."""
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, what or "it did not happen in time"
        page.wait_for_timeout(60)


def level(stack: Stack, page: Page) -> None:
    """Stand level until the interlock lets go."""
    bar = page.get_by_role("status").filter(has_text="Too steep")
    for _ in range(200):
        stack.robot.tell("metric {'name': 'tilt', 'magnitude': 0}")
        page.wait_for_timeout(100)
        if not bar.count():
            return
    raise AssertionError("the interlock did not let go")


@pytest.fixture
def page(plugged: Plugged, chrome: Browser) -> Page:
    """The driver's page for driving, the vehicle level and free."""
    if plugged.hub.popen.poll() is not None:
        plugged.start_hub()
    # As `Stack.fresh`, but for the loop, of which Playwright has one in this thread.
    if plugged.gateway.popen.poll() is not None or plugged.gateway.said().count("linked to") > 1:
        plugged.gateway.end()
        plugged.start_gateway()
    finish(plugged.ready())
    shown = visit(chrome, plugged, "driver", width=1280, path=f"/sites/{SITE}/drive")
    expect(shown.get_by_role("button", name="Take control")).to_be_enabled(timeout=PATIENCE_MS)
    level(plugged, shown)
    return shown


def take(page: Page) -> None:
    page.get_by_role("button", name="Take control").click()
    expect(page.get_by_text("You have control").first).to_be_visible()


def moves(stack: Stack, since: int) -> list[list[float]]:
    return [list(x.v) for x in stack.heard("/cmd_vel", since) if any(x.v)]  # type: ignore[call-overload]


def drives(stack: Stack, page: Page, since: int) -> list[float]:
    """Wait until it moves, and give how at last."""
    until(lambda: moves(stack, since), page, what="the vehicle did not move")
    page.wait_for_timeout(150)
    return moves(stack, since)[-1]


def stands(stack: Stack, page: Page, since: int) -> int:
    """Wait for zero with nothing behind it; give when the last motion was told (ns)."""

    def rests() -> bool:
        heard = stack.heard("/cmd_vel", since)
        # A zero between two frames that a busy machine held up is no end of the motion.
        moved = max((x.t for x in heard if any(x.v)), default=0)  # type: ignore[call-overload]
        return bool(heard) and heard[-1].t > moved and time.monotonic_ns() - moved > RESTS_NS

    until(rests, page, what="it moved on")
    heard = stack.heard("/cmd_vel", since)
    return next(
        (x.t for x, y in zip(heard[1:][::-1], heard[::-1][1:], strict=True) if any(y.v)),  # type: ignore[call-overload]
        heard[0].t,
    )


# ── hold to run ──


@pytest.mark.parametrize(
    ("key", "linear", "angular"),
    [
        ("w", 1, 0), ("x", -1, 0), ("a", 0, 1), ("d", 0, -1),
        ("ArrowUp", 1, 0), ("ArrowDown", -1, 0), ("ArrowLeft", 0, 1), ("ArrowRight", 0, -1),
    ],
)  # fmt: skip
def test_each_key_drives_its_way_while_it_is_held(
    plugged: Plugged, page: Page, key: str, linear: int, angular: int
) -> None:
    take(page)
    at = time.monotonic_ns()
    page.keyboard.down(key)
    told = drives(plugged, page, at)
    page.keyboard.up(key)
    released = time.monotonic_ns()
    assert [(each > 0) - (each < 0) for each in told] == [linear, angular]
    assert stands(plugged, page, at) - released < STOPPED_NS


def test_s_halts_though_w_is_still_held(plugged: Plugged, page: Page) -> None:
    take(page)
    at = time.monotonic_ns()
    page.keyboard.down("w")
    drives(plugged, page, at)
    page.keyboard.press("s")
    pressed = time.monotonic_ns()
    assert stands(plugged, page, at) - pressed < STOPPED_NS
    expect(page.get_by_text("Halted with the S key.")).to_be_visible()
    page.keyboard.up("w")


def middle(of: Locator) -> tuple[float, float, float]:
    box = of.bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, box["width"]


def test_the_pad_drives_while_a_pointer_holds_it(plugged: Plugged, page: Page) -> None:
    take(page)
    pad = page.get_by_role("application")
    pad.scroll_into_view_if_needed()
    x, y, width = middle(pad)
    at = time.monotonic_ns()
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y - width * 0.4)
    assert drives(plugged, page, at)[0] > 0
    page.mouse.up()
    released = time.monotonic_ns()
    assert stands(plugged, page, at) - released < STOPPED_NS


def test_the_pad_drives_under_a_finger_and_a_second_finger_changes_nothing(
    plugged: Plugged, page: Page
) -> None:
    take(page)
    pad = page.get_by_role("application")
    pad.scroll_into_view_if_needed()
    x, y, width = middle(pad)
    touch = page.context.new_cdp_session(page)

    def fingers(kind: str, *points: tuple[float, float]) -> None:
        listed = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(points)]
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": listed})

    at = time.monotonic_ns()
    fingers("touchStart", (x, y))
    fingers("touchMove", (x, y + width * 0.4))
    assert drives(plugged, page, at)[0] < 0
    fingers("touchStart", (x, y + width * 0.4), (x, y - width * 0.4))
    assert drives(plugged, page, time.monotonic_ns())[0] < 0
    fingers("touchEnd")
    released = time.monotonic_ns()
    assert stands(plugged, page, at) - released < STOPPED_NS


GAMEPAD = """
window.pad = {
  index: 0, id: "a pad of the tests", mapping: "standard", connected: true, timestamp: 0,
  axes: [0, 0, 0, 0], buttons: Array.from({length: 17}, () => ({pressed: false, value: 0})),
};
window.plugged = false;
navigator.getGamepads = () => [window.plugged ? window.pad : null];
window.plug = (is) => {
  window.plugged = is;
  const event = new Event(is ? "gamepadconnected" : "gamepaddisconnected");
  Object.defineProperty(event, "gamepad", {value: window.pad});
  window.dispatchEvent(event);
};
window.grip = (is) => { window.pad.buttons[4] = {pressed: is, value: is ? 1 : 0}; };
"""


def test_a_gamepad_drives_only_while_a_shoulder_button_is_held_and_its_loss_is_a_halt(
    plugged: Plugged, page: Page
) -> None:
    page.add_init_script(GAMEPAD)
    page.reload()
    take(page)
    at = time.monotonic_ns()
    page.evaluate("plug(true); pad.axes[1] = -1")
    page.wait_for_timeout(400)
    assert moves(plugged, at) == []
    page.evaluate("grip(true)")
    assert drives(plugged, page, at)[0] > 0
    page.evaluate("grip(false)")
    released = time.monotonic_ns()
    assert stands(plugged, page, at) - released < STOPPED_NS
    at = time.monotonic_ns()
    page.evaluate("grip(true)")
    drives(plugged, page, at)
    page.evaluate("plug(false)")
    lost = time.monotonic_ns()
    assert stands(plugged, page, at) - lost < STOPPED_NS
    expect(page.get_by_text("the gamepad is gone")).to_be_visible()


# ── commands ──


def test_an_action_is_run_from_the_page_told_of_and_called_off(
    plugged: Plugged, page: Page
) -> None:
    survey = page.locator("t-command").filter(has_text="Survey")
    time_s = survey.get_by_label("time")
    time_s.fill("61")
    survey.get_by_role("button", name="Send").click()
    expect(survey.get_by_text("60")).not_to_have_count(0)
    expect(survey.get_by_text("sent", exact=True)).to_have_count(0)
    time_s.fill("20")
    survey.get_by_role("button", name="Send").click()
    expect(survey.get_by_text("running")).to_be_visible(timeout=PATIENCE_MS)
    bar = survey.get_by_role("progressbar")
    expect(bar).to_be_visible()
    before = float(bar.get_attribute("value") or bar.evaluate("each => each.value"))
    until(lambda: float(bar.evaluate("each => each.value")) > before, page)
    picture(page, "by-hand-action")
    survey.get_by_role("button", name="Cancel it").click()
    expect(survey.get_by_text("cancelled")).to_be_visible(timeout=PATIENCE_MS)
    time_s.fill("1")
    survey.get_by_role("button", name="Send").click()
    expect(survey.get_by_text("succeeded")).to_be_visible(timeout=PATIENCE_MS)


def test_what_an_interlock_locks_is_greyed_out_with_the_reason_and_who_can_help(
    plugged: Plugged, chrome: Browser, page: Page
) -> None:
    take(page)
    at = time.monotonic_ns()
    page.keyboard.down("w")
    drives(plugged, page, at)
    plugged.robot.tell("metric {'name': 'tilt', 'magnitude': 30}")
    locked = "Locked by Too steep: Tilt is above 20 °. An admin can override it."
    expect(page.get_by_role("alert").filter(has_text=locked)).to_be_visible()
    stands(plugged, page, at)
    page.keyboard.up("w")
    beep = page.locator("t-command").filter(has_text="Beep")
    expect(beep.get_by_text(locked)).to_be_visible()
    expect(beep.get_by_role("button", name="Send")).to_be_disabled()
    survey = page.locator("t-command").filter(has_text="Survey")
    expect(survey.get_by_role("button", name="Send")).to_be_enabled()
    expect(page.get_by_role("application")).to_have_attribute("aria-disabled", "true")
    at = time.monotonic_ns()
    page.keyboard.down("w")
    page.wait_for_timeout(400)
    page.keyboard.up("w")
    assert moves(plugged, at) == []
    picture(page, "by-hand-locked")
    page.emulate_media(color_scheme="dark")
    page.set_viewport_size({"width": 390, "height": 900})
    beep.scroll_into_view_if_needed()
    expect(beep.get_by_text(locked)).to_be_visible()
    picture(page, "by-hand-locked-phone")
    page.set_viewport_size({"width": 1280, "height": 900})
    boss = visit(chrome, plugged, "boss", width=1280, path=f"/sites/{SITE}/drive")
    expect(
        boss.locator("t-command").filter(has_text="You can override it in the bar at the top.")
    ).to_have_count(1)
    boss.get_by_role("button", name="Show interlocks").click()
    boss.get_by_role("button", name="Override…").click()
    boss.get_by_label("Reason").fill("One person beside the robot")
    boss.get_by_role("button", name="Override", exact=True).click()
    expect(beep.get_by_role("button", name="Send")).to_be_enabled()
    boss.get_by_role("button", name="End override").click()
    expect(beep.get_by_role("button", name="Send")).to_be_disabled()


# ── pulling the plug ──


def test_the_hub_is_killed_while_driving_and_the_page_says_so_and_recovers(
    plugged: Plugged, page: Page
) -> None:
    take(page)
    at = time.monotonic_ns()
    page.keyboard.down("w")
    drives(plugged, page, at)
    killed = plugged.hub.kill()
    assert stands(plugged, page, at) - killed < STOPPED_NS
    expect(page.get_by_text("No connection to the hub. What you see is old")).to_be_visible()
    expect(
        page.get_by_text("The gateway brings the vehicle to rest by itself.").first
    ).to_be_visible()
    expect(page.get_by_text("You have control")).to_have_count(0)
    picture(page, "by-hand-hub-killed")
    plugged.start_hub()
    back = time.monotonic_ns()
    expect(page.get_by_role("button", name="Take control")).to_be_enabled(timeout=PATIENCE_MS)
    expect(page.get_by_text("No connection to the hub")).to_have_count(0)
    # The key was held all the while: nothing moves before it is let go, and control taken anew.
    page.wait_for_timeout(500)
    assert moves(plugged, back) == []
    page.keyboard.up("w")
    take(page)
    at = time.monotonic_ns()
    page.keyboard.down("w")
    drives(plugged, page, at)
    page.keyboard.up("w")
    stands(plugged, page, at)
    picture(page, "by-hand-hub-back")


def test_a_page_that_loses_its_network_stops_the_vehicle(plugged: Plugged, page: Page) -> None:
    cable = plugged.cable
    cable.looked_for[Way.DOWN] = DRIVING_FRAME
    take(page)
    at = time.monotonic_ns()
    page.keyboard.down("w")
    drives(plugged, page, at)
    assert cable.seen_ns[Way.DOWN] > at
    session = page.context.new_cdp_session(page)
    frozen: list[object] = []
    session.on("Debugger.paused", lambda event: frozen.append(event))
    # The page itself freezes: no frame, no goodbye; only the gateway's watchdog is left.
    session.send("Debugger.enable")
    session.send("Debugger.pause")
    until(lambda: frozen, page, what="the page did not freeze")
    stopped = stands(plugged, page, at)
    # From the last frame at the gateway's door: to freeze, the page takes its time.
    assert stopped - cable.seen_ns[Way.DOWN] < STOPPED_NS
    session.send("Debugger.resume")
    page.keyboard.up("w")


def test_the_network_stops_while_values_are_logged_and_none_of_them_is_lost(
    plugged: Plugged, page: Page
) -> None:
    page.goto(f"{plugged.address}/sites/{SITE}/live")
    count = page.get_by_role("heading", name="Count")
    expect(count).to_be_visible(timeout=PATIENCE_MS)
    pulled_us = time.time_ns() // 1000
    plugged.cable.change(DARK)
    try:
        # Stale at once, and that the gateway is gone after three missed beats.
        expect(page.get_by_text("stale").first).to_be_visible(timeout=4000)
        banner = page.get_by_role("status").filter(has_text="has been offline since")
        expect(banner).to_be_visible(timeout=8000)
        picture(page, "by-hand-network-gone")
        page.wait_for_timeout(2000)
    finally:
        plugged.cable.cut()
        plugged.cable.change(Weather())
    expect(banner).to_have_count(0, timeout=PATIENCE_MS)
    back_us = time.time_ns() // 1000
    window = f"channel=base/count&width=4000&from_us={pulled_us}&to_us={back_us}"

    def whole() -> bool:
        answer = page.request.get(f"{plugged.address}/api/sites/{SITE}/history?{window}")
        (series,) = answer.json()["series"]
        values = series["v"]
        return len(values) > 100 and values == [values[0] + at for at in range(len(values))]

    until(whole, page, what="the values of the dark time are not all there")
    picture(page, "by-hand-network-back")


def test_a_second_gateway_with_the_same_key_is_told_of_on_every_page(
    plugged: Plugged, page: Page, tmp_path: Path
) -> None:
    words = list(plugged.gateway.popen.args)[1:]  # type: ignore[arg-type, call-overload]
    words[words.index("--data") + 1] = str(tmp_path)
    rival = Process(words, tmp_path / "rival.log", plugged._ros)
    try:
        alarm = page.get_by_role("status").filter(has_text="A second gateway uses the key of")
        expect(alarm).to_be_visible(timeout=PATIENCE_MS)
        expect(alarm).to_contain_text("Switch the other one off")
        # Neither has gone: the second one waits.
        assert rival.popen.poll() is None
        page.goto(f"{plugged.address}/home")
        expect(alarm).to_be_visible(timeout=PATIENCE_MS)
        picture(page, "by-hand-second-gateway")
    finally:
        rival.end()
        plugged.gateway.end()
        plugged.start_gateway()
