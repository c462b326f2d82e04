"""Every way of a picture to a real page: what is drawn is compared with what the robot sent."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from patience import PATIENCE_MS
from PIL import Image
from playwright.sync_api import Browser, Page as BrowserPage, expect
from tests.gateway.adapters.video.rtsp_camera import RtspCamera
from tests.gateway.video.scenes import packed, psnr, scene

from .conftest import missing
from .pages import picture, visit
from .stack import SITE, Process, Stack, finish

pytestmark = [pytest.mark.robot, pytest.mark.browser]

IMAGES = ("rgb8", "yuyv", "bayer_rggb8", "mono16", "unknown", "short")
COMPRESSED = ("jpeg", "cut")
BAD = {
    "unknown": "'yuv9' is not known here",
    "short": "the picture is cut off",
    "cut": "is cut off",
}
STREAM = "      {0}: {{name: {0}, source: {{topic: /cam/{0}, type: sensor_msgs/msg/{1}}}}}\n"
DESCRIPTION = (
    "talaia: 1\nsite: faults\nname: Cameras\nros2: {}\n"
    "connections:\n  yard: {kind: video, here: true}\n"
    "devices:\n  gate:\n    name: Gate\n    connection: yard\n    streams:\n"
    "      rtsp: {name: rtsp, source: {url: 'rtsp://127.0.0.1:%d/gate'}}\n"
    "  eyes:\n    name: Eyes\n    connection: ros2\n    streams:\n"
)
DESCRIPTION += "".join(STREAM.format(each, "Image") for each in IMAGES)
DESCRIPTION += "".join(STREAM.format(each, "CompressedImage") for each in COMPRESSED)
NOTE = """
window.__formats = [];
window.__talaiaPictured = (timeUs, format) => window.__formats.push(format);
window.__until = format => new Promise(done => {
  const look = () => {
    const newest = window.__formats.slice(-20);
    if (newest.length === 20 && newest.every(each => each === format)) done(true);
    else requestAnimationFrame(look);
  };
  look();
});
"""
# A tab that another one covers.
COVERED = """
window.__cover = covered => {
  Object.defineProperty(document, "hidden", {configurable: true, get: () => covered});
  document.dispatchEvent(new Event("visibilitychange"));
};
"""
# As in a browser without it, and in each one where the page is not on https.
NO_DECODER = "delete window.VideoDecoder;"


@pytest.fixture(scope="module")
def stack(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stack]:
    for module in ("rclpy", "av"):
        if not __import__("importlib.util").util.find_spec(module):
            missing(module)
    folder = tmp_path_factory.mktemp("cameras")
    yard = RtspCamera([scene(320, 240)] * 10)
    running = Stack(folder, DESCRIPTION % yard.port, {"boss": "admin"})
    cameras = Process(
        [str(Path(__file__).parent / "camera_robot.py")], folder / "cameras.log", running._ros
    )
    try:
        finish(running.ready())
        finish(cameras.says("ready"))
        yield running
    finally:
        cameras.end()
        running.close()
        yard.close()


def opened(chrome: Browser, stack: Stack, *scripts: str, device: str = "eyes") -> BrowserPage:
    # So tall that each camera is in sight: the others would rest.
    path = f"/sites/{SITE}/devices/{device}"
    return visit(chrome, stack, "boss", height=3000, scripts=scripts, path=path)


def camera(page: BrowserPage, name: str):
    return page.locator(f"t-camera[data-stream$='/{name}']")


def drawn(page: BrowserPage, name: str) -> np.ndarray:
    expect(camera(page, name).get_by_text("Live", exact=True)).to_be_visible(timeout=PATIENCE_MS)
    url = camera(page, name).locator("canvas").evaluate("canvas => canvas.toDataURL('image/png')")
    with Image.open(io.BytesIO(base64.b64decode(url.split(",")[1]))) as image:
        return np.array(image.convert("RGB"))


@pytest.mark.parametrize(
    ("scripts", "format_"), [((NOTE,), "h264"), ((NOTE, NO_DECODER), "jpeg")], ids=["h264", "jpeg"]
)
def test_what_is_drawn_is_what_the_robot_sent_and_bad_pictures_say_what_is_wrong(
    stack: Stack, chrome: Browser, scripts: tuple[str, ...], format_: str
) -> None:
    page = opened(chrome, stack, *scripts)
    sent = scene(320, 240)
    for name in ("rgb8", "yuyv", "bayer_rggb8", "jpeg"):
        seen = drawn(page, name)
        assert seen.shape == sent.shape
        assert psnr(seen, sent) > 28, name
    grey = packed(sent, "mono8").data.reshape(240, 320, 1)
    assert psnr(drawn(page, "mono16"), grey) > 28
    for name, words in BAD.items():
        expect(camera(page, name).get_by_text("cannot be shown")).to_be_visible(timeout=PATIENCE_MS)
        expect(camera(page, name).get_by_text(words)).to_be_visible()
    assert set(page.evaluate("window.__formats")) == {format_}
    picture(page, f"cameras-{format_}")
    assert stack.gateway.popen.poll() is None


@pytest.mark.parametrize(
    ("scripts", "format_"), [((NOTE,), "h264"), ((NOTE, NO_DECODER), "jpeg")], ids=["h264", "jpeg"]
)
def test_a_network_camera_is_drawn_as_it_was_filmed(
    stack: Stack, chrome: Browser, scripts: tuple[str, ...], format_: str
) -> None:
    page = opened(chrome, stack, *scripts, device="gate")
    # Filmed by the camera and, for the page, once more.
    assert psnr(drawn(page, "rtsp"), scene(320, 240)) > 26
    assert set(page.evaluate("window.__formats")) == {format_}


def test_a_covered_page_gets_a_picture_now_and_then_and_the_film_again_when_it_is_seen(
    stack: Stack, chrome: Browser
) -> None:
    page = opened(chrome, stack, NOTE, COVERED)
    drawn(page, "rgb8")
    page.evaluate("window.__cover(true)")
    page.evaluate("window.__until('jpeg')")
    assert psnr(drawn(page, "rgb8"), scene(320, 240)) > 28
    page.evaluate("window.__cover(false)")
    page.evaluate("window.__until('h264')")
    assert psnr(drawn(page, "rgb8"), scene(320, 240)) > 28


def test_a_camera_is_looked_at_closely_and_kept(stack: Stack, chrome: Browser) -> None:
    page = opened(chrome, stack)
    drawn(page, "rgb8")
    one = camera(page, "rgb8")
    canvas = one.locator("canvas")
    lens = one.locator(".lens")
    lens.hover(position={"x": 10, "y": 10})
    page.mouse.wheel(0, -300)
    assert canvas.evaluate("each => each.style.transform") == ""
    # Where it lies now: a plain wheel scrolls the page, and pictures that come move what is below.
    lens.hover(position={"x": 10, "y": 10})
    page.keyboard.down("Control")
    page.mouse.wheel(0, -300)
    page.keyboard.up("Control")
    expect(canvas).to_have_attribute("style", re.compile("scale"))
    one.get_by_role("button", name="Show all of the picture").click()
    expect(canvas).not_to_have_attribute("style", re.compile("scale"))
    lens.focus()
    page.keyboard.press("+")
    expect(canvas).to_have_attribute("style", re.compile("scale"))
    with page.expect_download() as caught:
        one.get_by_role("button", name="Save this picture").click()
    kept = caught.value
    assert kept.suggested_filename.startswith("rgb8-20")
    with Image.open(kept.path()) as image:
        assert image.size == (320, 240)
        assert psnr(np.array(image.convert("RGB")), scene(320, 240)) > 28
    one.get_by_role("button", name="Full screen").click()
    expect(one.get_by_role("button", name="Leave full screen")).to_be_visible()
    picture(page, "camera-full")
    one.get_by_role("button", name="Leave full screen").click()
    expect(one.get_by_role("button", name="Full screen", exact=True)).to_be_visible()
