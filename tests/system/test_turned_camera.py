"""A camera that turns, as people have it in hand: over ONVIF and RTSP, in a real Chromium."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from patience import PATIENCE_S
from playwright.sync_api import Browser, Page, expect
from tests.gateway.adapters.video.rtsp_camera import RtspCamera
from tests.gateway.video.scenes import scene

from .pages import picture, sign_in_unseen, visit
from .stack import PASSWORD, SITE, Process, Stack, finish

GATEWAY = Path(__file__).parents[1] / "gateway/adapters"
sys.path.insert(0, str(GATEWAY / "onvif"))
from onvif_camera import OnvifCamera, serving_camera  # noqa: E402

pytestmark = [pytest.mark.robot, pytest.mark.browser]

DESCRIPTION = """\
talaia: 1
site: faults
name: Yard
connections:
  gate: {kind: onvif, url: "http://127.0.0.1:%d/onvif/device_service", here: true, poll: 0.5}
devices:
  gate:
    name: Gate camera
    kind: camera
    streams:
      main: {name: Gate, source: {url: "rtsp://127.0.0.1:%d/main"}}
    signals:
      pan: {name: Pan, decimals: 2, source: {ptz: pan}}
      tilt: {name: Tilt, decimals: 2, source: {ptz: tilt}}
      zoom: {name: Zoom, decimals: 2, source: {ptz: zoom}}
      moving: {name: Moves, source: {ptz: moving}}
      presets: {name: Presets, type: text, max_age: 0, source: {ptz: presets}}
    commands:
      goto_preset:
        name: Go to preset
        kind: onvif
        target: GotoPreset
        timeout: 30
        arguments: {preset: {type: text, field: preset, name: Preset, max_length: 64}}
      set_preset:
        name: Keep as preset
        kind: onvif
        target: SetPreset
        arguments: {preset: {type: text, field: preset, name: Preset, max_length: 64}}
      home: {name: Go home, kind: onvif, target: GotoHomePosition}
      stop: {name: Stop, kind: onvif, target: Stop}
    drive:
      message: ptz
      joints: {pan: {max_speed: 1}, tilt: {max_speed: 1}, zoom: {max_speed: 1}}
      picture: gate/main
      stop: {confirmed_by: [gate/moving]}
"""
PEOPLE = {"guard": "operator", "second": "operator", "boss": "admin"}


class Yard(Stack):
    """A hub and a gateway whose robot is a camera in this process."""

    def __init__(self, folder: Path, port: int, stream: int) -> None:  # noqa: D107
        super().__init__(folder, DESCRIPTION % (port, stream), PEOPLE)

    def start_robot(self) -> Process:
        words = ["-c", "print('ready'); input()"]
        return Process(words, self.folder / "robot.log", {})


@pytest.fixture(scope="module")
def yard(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Yard, OnvifCamera]]:
    film = RtspCamera([scene(640, 480)] * 10)
    with serving_camera() as (port, camera):
        camera.presets = {
            "1": ("Gate", {"pan": 0.3, "tilt": 0.1, "zoom": 0.0}),
            "2": ("Parking", {"pan": -0.6, "tilt": 0.0, "zoom": 0.2}),
        }
        running = Yard(tmp_path_factory.mktemp("yard"), port, film.port)
        try:
            finish(running.ready())
            yield running, camera
        finally:
            running.close()
            film.close()


def until(true: Callable[[], object], page: Page, what: str) -> None:
    """Wait for something outside the page while the page lives on."""
    end = time.monotonic() + PATIENCE_S
    while not true():
        assert time.monotonic() < end, what
        page.wait_for_timeout(60)


def add_visitor(chrome: Browser, stack: Yard) -> None:
    """Make a person who may look, and nothing more."""
    boss = chrome.new_context().new_page()
    sign_in_unseen(boss, stack, "boss")
    role = {"name": "watchers", "permissions": [{"right": "view", "site": SITE, "device": "*"}]}
    person = {"name": "visitor", "password": PASSWORD, "role": "watchers"}
    for path, made in (("roles", role), ("people", person)):
        answer = boss.context.request.post(
            f"{stack.address}/api/{path}", data=made, headers={"Origin": stack.address}
        )
        assert answer.ok, answer.text()


def test_a_guard_turns_it_by_button_and_key_and_goes_to_presets(
    yard: tuple[Yard, OnvifCamera], chrome: Browser
) -> None:
    stack, camera = yard
    page = visit(chrome, stack, "guard", path="/sites/faults/drive")
    up = page.get_by_role("button", name="Tilt up")
    expect(up).to_be_disabled()
    picture(page, "ptz-free")
    page.get_by_role("button", name="Take control").click()
    expect(up).to_be_enabled()
    up.hover()
    page.mouse.down()
    until(lambda: camera.place()["tilt"] > 0.1, page, "it has tilted up")
    page.mouse.up()
    until(lambda: not camera.is_moving(), page, "it rests")
    # Where it looks, by its own word.
    expect(page.get_by_label("Where it looks")).to_contain_text("0.")
    before = camera.place()["pan"]
    page.keyboard.down("ArrowLeft")
    until(lambda: camera.place()["pan"] < before - 0.1, page, "it has panned left")
    page.keyboard.up("ArrowLeft")
    until(lambda: not camera.is_moving(), page, "it rests")
    page.keyboard.down("e")
    until(lambda: camera.place()["zoom"] > 0.1, page, "it has zoomed in")
    # A page that loses the focus lets go.
    page.evaluate("window.dispatchEvent(new Event('blur'))")
    until(lambda: not camera.is_moving(), page, "it rests")
    page.keyboard.up("e")
    page.get_by_role("button", name="Gate", exact=True).click()
    until(lambda: abs(camera.place()["pan"] - 0.3) < 0.02, page, "it is there")
    expect(page.get_by_text("Go to preset: succeeded")).to_be_visible()
    picture(page, "ptz-mine")


def test_a_second_person_sees_who_has_it_and_a_guest_may_only_look(
    yard: tuple[Yard, OnvifCamera], chrome: Browser
) -> None:
    stack, camera = yard
    guard = visit(chrome, stack, "guard", path="/sites/faults/drive")
    guard.get_by_role("button", name="Take control").click()
    expect(guard.get_by_role("button", name="Tilt up")).to_be_enabled()
    second = visit(chrome, stack, "second", path="/sites/faults/drive")
    expect(second.get_by_text("guard has control")).to_be_visible()
    expect(second.get_by_role("button", name="Tilt up")).to_be_disabled()
    second.get_by_role("button", name="Parking", exact=True).click()
    expect(second.get_by_text("guard drives it")).to_be_visible()
    picture(second, "ptz-other")
    assert camera.asked["GotoPreset"] <= 1
    add_visitor(chrome, stack)
    visitor = visit(chrome, stack, "visitor", path="/sites/faults/drive")
    expect(visitor.get_by_text("needs the right")).to_be_visible()
    assert visitor.get_by_role("button", name="Tilt up").count() == 0
    assert visitor.get_by_role("button", name="Parking").count() == 0
    picture(visitor, "ptz-forbidden")


def test_a_camera_that_falls_silent_says_so_and_takes_no_press(
    yard: tuple[Yard, OnvifCamera], chrome: Browser
) -> None:
    stack, camera = yard
    page = visit(chrome, stack, "guard", path="/sites/faults/drive")
    page.get_by_role("button", name="Take control").click()
    expect(page.get_by_role("button", name="Tilt up")).to_be_enabled()
    camera.silent |= {"GetStatus", "GetPresets", "GetSystemDateAndTime"}
    expect(page.get_by_text("The camera does not answer")).to_be_visible()
    expect(page.get_by_role("button", name="Tilt up")).to_be_disabled()
    picture(page, "ptz-silent")
    camera.silent.clear()
    expect(page.get_by_text("The camera does not answer")).to_have_count(0)
