"""Films beside the charts in a real page: what is shown of a moment is what was sent then."""

from __future__ import annotations

import base64
import io
import re
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import httpx
import numpy as np
import pytest
from patience import PATIENCE_MS, PATIENCE_S
from PIL import Image
from playwright.sync_api import Browser, Locator, Page as BrowserPage, expect
from shared_trust import usual_trust
from tests.gateway.video.scenes import number_in, numbered, psnr

from .conftest import missing
from .pages import picture, visit
from .stack import PASSWORD, SITE, STEP_S, Process, Stack, finish

pytest.importorskip("av")

import av
from tests.gateway.adapters.video.rtsp_camera import RtspCamera

pytestmark = [pytest.mark.robot, pytest.mark.browser]

DESCRIPTION = """
talaia: 1
site: faults
name: Films
zone: Europe/Madrid
connections:
  ros: {{kind: ros2}}
  cameras: {{kind: video, here: true}}
recording: {{cameras: [eyes/ros], before: 5, after: 5, upload: 20000, triggers: [stop]}}
devices:
  eyes:
    name: Eyes
    connection: ros
    signals:
      number: {{name: Number, source: {{topic: /number, type: std_msgs/msg/Float64, field: data}}}}
    streams:
      ros: {{name: Robot, source: {{topic: /cam, type: sensor_msgs/msg/Image}}}}
  gate:
    name: Gate
    connection: cameras
    streams:
      road: {{name: Road, source: {{url: "rtsp://127.0.0.1:{port}/x"}}}}
"""
API = f"/api/sites/{SITE}"


class Yard(Stack):
    """A site with a robot's camera and a network camera."""

    def __init__(self, folder: Path) -> None:
        """Start both cameras beside hub and gateway."""
        self.camera = RtspCamera([numbered(at) for at in range(100)])
        super().__init__(folder, DESCRIPTION.format(port=self.camera.port), {"boss": "admin"})
        self.sent = folder / "sent.txt"
        words = [str(Path(__file__).parent / "film_robot.py"), str(self.sent)]
        self.eyes = Process(words, folder / "eyes.log", self._ros)
        self.client = httpx.Client(
            base_url=self.address,
            headers={"Origin": self.address},
            timeout=PATIENCE_S,
            verify=usual_trust(),
        )

    def number_at(self, time_us: int) -> int:
        """Give the number that was the newest one at a moment."""
        lines = (line.split() for line in self.sent.read_text().splitlines())
        return [int(number) for number, at in lines if int(at) // 1000 <= time_us][-1]

    def sign_in(self) -> None:
        said = self.client.post("/api/login", json={"name": "boss", "password": PASSWORD})
        assert said.status_code == 200, said.text

    def films(self, stream: str = "") -> list[dict]:
        found = self.client.get(f"{API}/films").json()["films"]
        return [
            each
            for each in found
            if each["state"] == "complete" and each["stream"] in (stream or each["stream"],)
        ]

    def close(self) -> None:
        self.client.close()
        self.eyes.end()
        super().close()
        self.camera.close()


@pytest.fixture(scope="module")
def yard(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Yard]:
    if not __import__("importlib.util").util.find_spec("rclpy"):
        missing("rclpy")
    running = Yard(tmp_path_factory.mktemp("films"))
    try:
        finish(running.ready())
        finish(running.eyes.says("ready"))
        running.sign_in()
        yield running
    finally:
        running.close()


def opened(chrome: Browser, yard: Yard, path: str) -> BrowserPage:
    return visit(chrome, yard, "boss", height=1200, path=f"/sites/{SITE}/{path}")


def view(page: BrowserPage, stream: str) -> Locator:
    return page.locator(f"t-film-view[data-stream='{stream}']")


SHOT = """async view => {
  const [video, canvas] = ["video", "canvas"].map(name => view.renderRoot.querySelector(name));
  // Settled: where it is to stand, and its picture on the screen.
  for (let quiet = 0; quiet < 8; ) {
    const before = view.shownUs;
    await new Promise(done => requestAnimationFrame(done));
    const still = view.shownUs > 0 && view.shownUs === before;
    quiet = still && view.ready && (!canvas.hidden || view.times !== null) ? quiet + 1 : 0;
  }
  // What a person sees: the film, or the picture that covers it while it stands still.
  const seen = canvas.hidden ? video : canvas;
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = canvas.hidden
    ? [video.videoWidth, video.videoHeight] : [canvas.width, canvas.height];
  copy.getContext("2d").drawImage(seen, 0, 0);
  return [view.shownUs, copy.toDataURL("image/png"), seen.localName];
}"""


def shot(
    page: BrowserPage, stream: str, by: tuple[str, ...] = ("canvas",)
) -> tuple[int, np.ndarray]:
    """Give the picture that stands there, and the time that is said of it (µs)."""
    one = view(page, stream)
    expect(one.locator("video")).to_be_visible(timeout=PATIENCE_MS)
    shown_us, url, seen = one.evaluate(SHOT)
    assert seen in by
    with Image.open(io.BytesIO(base64.b64decode(url.split(",")[1]))) as image:
        return shown_us, np.array(image.convert("RGB"))


def decoded(client: httpx.Client, film: dict, folder: Path) -> dict[int, np.ndarray]:
    """Give each picture of a film by the moment when it came (µs), by another decoder."""
    path = folder / f"{film['id']}.mp4"
    path.write_bytes(client.get(f"{API}/films/{film['id']}/file").content)
    with av.open(str(path)) as opened_film:
        return {
            film["begin_us"] + each.pts: each.to_ndarray(format="rgb24")
            for each in opened_film.decode(video=0)
        }


def wait_for(condition: Callable[[], object], within: float = PATIENCE_S) -> None:
    """Wait beside a page, whose own loop leaves no room for `until`."""
    deadline = time.monotonic() + within
    while not condition():
        assert time.monotonic() < deadline, "not in time"
        time.sleep(STEP_S)


@pytest.fixture(scope="module")
def filmed(yard: Yard, browser: Browser) -> dict[str, dict]:
    """Have both cameras filmed by a person at their tiles."""
    page = opened(browser, yard, "cameras")
    for stream in ("eyes/ros", "gate/road"):
        tile = page.locator(f"t-camera[data-stream='{stream}']")
        tile.get_by_role("button", name="Film this camera").click(timeout=PATIENCE_MS)
        expect(tile.get_by_role("button", name="End the film")).to_be_visible(timeout=PATIENCE_MS)
    picture(page, "filming")
    # Long enough for two pictures to begin with.
    page.wait_for_timeout(6000)
    for stream in ("eyes/ros", "gate/road"):
        tile = page.locator(f"t-camera[data-stream='{stream}']")
        tile.get_by_role("button", name="End the film").click()
        expect(tile.get_by_role("button", name="Film this camera")).to_be_visible(
            timeout=PATIENCE_MS
        )
    page.context.close()
    wait_for(lambda: len({each["stream"] for each in yard.films()}) == 2)
    return {stream: yard.films(stream)[0] for stream in ("eyes/ros", "gate/road")}


def window(film: dict, at_us: int) -> str:
    span = f"from={film['begin_us'] - 3_000_000}&to={film['end_us'] + 3_000_000}"
    return f"history?c=eyes/number&{span}&at={at_us}"


def test_the_picture_at_a_moment_is_the_one_that_was_sent_then(
    yard: Yard, chrome: Browser, filmed: dict[str, dict], tmp_path: Path
) -> None:
    film = filmed["eyes/ros"]
    client = yard.client
    by_time = decoded(client, film, tmp_path)
    times = sorted(by_time)
    assert len(times) == film["pictures"] > 40
    # What is in the file is what the robot sent, when it sent it; and so is what was before.
    assert times[0] < film["end_us"] - 5_000_000
    for at, image in by_time.items():
        assert number_in(image) == yard.number_at(at)
    assert max(b - a for a, b in pairwise(times)) < 400_000
    page = opened(chrome, yard, window(film, times[10] + 1000))
    for at in (times[10], times[-3], times[25], times[0], times[-1], times[26]):
        page.locator("t-page-history").evaluate("(page, us) => page.films.seek(us)", at + 20_000)
        page.wait_for_function(
            "([view, us]) => view.shownUs === us",
            arg=[view(page, "eyes/ros").element_handle(), at],
        )
        shown_us, image = shot(page, "eyes/ros")
        assert shown_us == at
        assert number_in(image) == number_in(by_time[at]) == yard.number_at(at)
        assert psnr(image[70:], by_time[at][70:]) > 30
    # The other camera's film stands at the same moment.
    road = decoded(client, filmed["gate/road"], tmp_path)
    middle = sorted(road)[len(road) // 2]
    page.locator("t-page-history").evaluate("(page, us) => page.films.seek(us)", middle)
    page.wait_for_function(
        "([view, us]) => view.shownUs === us",
        arg=[view(page, "gate/road").element_handle(), middle],
    )
    assert number_in(shot(page, "gate/road")[1]) == number_in(road[middle])
    robot_us, robot_picture = shot(page, "eyes/ros")
    assert robot_us == max(each for each in times if each <= middle)
    assert number_in(robot_picture) == number_in(by_time[robot_us])
    picture(page, "films-beside-charts")


def cursor_of(page: BrowserPage) -> float:
    return page.locator("t-history-chart").first.evaluate("chart => chart.cursorUs")


def test_playing_moves_the_charts_cursor_and_the_cursor_moves_the_film(
    yard: Yard, chrome: Browser, filmed: dict[str, dict], tmp_path: Path
) -> None:
    film = filmed["eyes/ros"]
    times = sorted(decoded(yard.client, film, tmp_path))
    page = opened(chrome, yard, window(film, times[5]))
    panel = page.locator("t-film-panel")
    assert shot(page, "eyes/ros")[0] == times[5]
    assert cursor_of(page) == times[5]
    # A picture on and back, by button and by key, each exactly one.
    panel.get_by_role("button", name="A picture on").click()
    seen = []
    for key in (".", ".", ","):
        page.keyboard.press(key)
        seen.append(number_in(shot(page, "eyes/ros")[1]))
    assert len(set(seen)) >= 2
    # Both cameras' pictures are stepped through; alone it is exactly the next one.
    panel.get_by_role("checkbox", name="Road").uncheck()
    expect(view(page, "gate/road")).to_have_count(0)
    page.locator("t-page-history").evaluate("(page, us) => page.films.seek(us)", times[20])
    assert shot(page, "eyes/ros")[0] == times[20]
    for step, key in ((21, "."), (22, "."), (21, ",")):
        page.keyboard.press(key)
        page.wait_for_function(
            "([view, us]) => view.shownUs === us",
            arg=[view(page, "eyes/ros").element_handle(), times[step]],
        )
        assert cursor_of(page) == times[step]
    # Faster, and the cursor goes with it.
    panel.get_by_label("Speed").select_option("2")
    page.get_by_role("heading", name="History").click()
    page.keyboard.press(" ")
    expect(panel.get_by_role("button", name="Pause")).to_be_visible()
    page.wait_for_function(
        "([view, us]) => view.shownUs > us",
        arg=[view(page, "eyes/ros").element_handle(), times[30]],
    )
    moved = cursor_of(page)
    assert moved > times[28]
    page.keyboard.press(" ")
    expect(panel.get_by_role("button", name="Play")).to_be_visible()
    shown_us, image = shot(page, "eyes/ros")
    assert number_in(image) == yard.number_at(shown_us)
    assert abs(cursor_of(page) - shown_us) < 400_000
    # The pointer on the chart takes the film along.
    chart = page.locator("t-history-chart t-chart").first
    box = chart.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] * 0.5, box["y"] + box["height"] / 2)
    moment = cursor_of(page)
    there_us, image = shot(page, "eyes/ros")
    assert there_us == max(each for each in times if each <= moment)
    assert number_in(image) == yard.number_at(there_us)
    page.mouse.click(box["x"] + box["width"] * 0.6, box["y"] + box["height"] / 2)
    page.mouse.move(5, 5)
    clicked_us, _ = shot(page, "eyes/ros")
    assert clicked_us > there_us
    assert abs(cursor_of(page) - clicked_us) < 400_000


def test_a_moment_without_film_says_so_and_leads_to_the_next_one(
    yard: Yard, chrome: Browser, filmed: dict[str, dict]
) -> None:
    film = filmed["eyes/ros"]
    page = opened(chrome, yard, window(film, film["begin_us"] - 2_000_000))
    one = view(page, "eyes/ros")
    expect(one.get_by_text("No film of this moment")).to_be_visible(timeout=PATIENCE_MS)
    one.get_by_role("button", name=re.compile("^Next")).click()
    assert shot(page, "eyes/ros")[0] == film["begin_us"]
    # To its end: it plays that far, and stands.
    page.locator("t-film-panel").get_by_label("Speed").select_option("16")
    page.keyboard.press(" ")
    expect(page.locator("t-film-panel").get_by_role("button", name="Play")).to_be_visible(
        timeout=PATIENCE_MS
    )
    picture(page, "film-ended")


def test_a_recording_s_mark_and_the_list_lead_to_the_film(
    yard: Yard, chrome: Browser, filmed: dict[str, dict]
) -> None:
    film = filmed["gate/road"]
    page = opened(chrome, yard, "recordings")
    page.get_by_role("link", name=f"Watch {film['id']}").click()
    page.wait_for_url("**/history?*at=*")
    assert shot(page, "gate/road")[0] == film["begin_us"]
    # The logbook's link is the moment of what happened.
    page.goto(f"{yard.address}/sites/{SITE}/logbook?kind=recording")
    page.get_by_role("link", name="Chart").first.click()
    page.wait_for_url("**/history?*at=*")
    at = int(re.search(r"at=(\d+)", page.url)[1])
    expect(page.locator("t-film-panel")).to_be_visible(timeout=PATIENCE_MS)
    assert page.locator("t-film-panel").evaluate("panel => panel.us") == at
    # A mark in the lane takes cursor and film to its moment.
    mark = page.locator("t-marks-lane").get_by_role("button", name=re.compile("recording"))
    mark.first.click()
    mark_us = float(mark.first.get_attribute("data-at"))
    assert page.locator("t-film-panel").evaluate("panel => panel.us") == pytest.approx(mark_us)


def test_a_killed_gateway_s_film_comes_when_it_is_back(
    yard: Yard, filmed: dict[str, dict], tmp_path: Path
) -> None:
    client = yard.client
    before = {each["id"] for each in yard.films()}
    ask = {"on": True, "stream": "eyes/ros", "why": "a kill"}
    assert client.post(f"{API}/recordings", json=ask).status_code == 202
    wait_for(lambda: "eyes/ros" in client.get(f"{API}/films").json()["filming"])
    # Once some seconds of it are on the disk.
    parts = yard.folder / "gateway" / "films"
    wait_for(lambda: any(each.stat().st_size > 300_000 for each in parts.glob("*.part")))
    killed_us = time.time_ns() // 1000
    yard.gateway.kill()
    yard.start_gateway()
    wait_for(lambda: "linked to" in yard.gateway.said())
    wait_for(lambda: {each["id"] for each in yard.films()} - before)
    (film,) = [each for each in yard.films() if each["id"] not in before]
    assert film["why"] == "a kill"
    assert "in the middle" in film["note"]
    by_time = decoded(client, film, tmp_path)
    assert len(by_time) == film["pictures"] > 20
    assert killed_us - max(by_time) < 1_500_000
    for at, image in by_time.items():
        # It is timed when it comes; on a machine with much to do the next one is sent before that.
        assert yard.number_at(at) - number_in(image) in (0, 1)
