"""Every way of a picture to a real page: what is drawn is compared with what the robot sent."""

from __future__ import annotations

import asyncio
import base64
import io
import os
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, Page as BrowserPage, Playwright, expect, sync_playwright
from tests.gateway.pictures.scenes import packed, psnr, scene

from .conftest import CHROMIUM_FLAGS, missing
from .stack import PASSWORD, SITE, Process, Stack

pytestmark = [pytest.mark.robot, pytest.mark.browser, pytest.mark.timeout(180)]

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
    "devices:\n  eyes:\n    name: Eyes\n    streams:\n"
)
DESCRIPTION += "".join(STREAM.format(each, "Image") for each in IMAGES)
DESCRIPTION += "".join(STREAM.format(each, "CompressedImage") for each in COMPRESSED)
NOTE = """
window.__formats = [];
window.__talaiaPictured = (timeUs, format) => window.__formats.push(format);
"""
# As in a browser without it, and in each one where the page is not on https.
NO_DECODER = "delete window.VideoDecoder;"


@pytest.fixture(scope="module")
def stack(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stack]:
    for module in ("rclpy", "av"):
        if not __import__("importlib.util").util.find_spec(module):
            missing(module)
    folder = tmp_path_factory.mktemp("cameras")
    running = Stack(folder, DESCRIPTION, {"boss": "admin"})
    cameras = Process(
        [str(Path(__file__).parent / "camera_robot.py")], folder / "cameras.log", running._ros
    )
    try:
        asyncio.run(running.ready())
        asyncio.run(cameras.says("ready"))
        yield running
    finally:
        cameras.end()
        running.close()


@pytest.fixture(scope="module")
def play() -> Iterator[Playwright]:
    with sync_playwright() as playing:
        yield playing


@pytest.fixture
def chrome(play: Playwright, chromium: str) -> Iterator[Browser]:
    clean = {key: value for key, value in os.environ.items() if key != "LD_LIBRARY_PATH"}
    browser = play.chromium.launch(executable_path=chromium, args=CHROMIUM_FLAGS, env=clean)
    yield browser
    browser.close()


def opened(chrome: Browser, stack: Stack, *scripts: str) -> BrowserPage:
    # So tall that each camera is in sight: the others would rest.
    page = chrome.new_context(viewport={"width": 1440, "height": 3000}).new_page()
    for each in scripts:
        page.add_init_script(each)
    page.goto(f"{stack.address}/login")
    page.get_by_label("Name").fill("boss")
    page.get_by_label("Password").fill(PASSWORD)
    page.get_by_role("button", name="Sign in").click()
    page.wait_for_url("**/home")
    page.goto(f"{stack.address}/sites/{SITE}/devices/eyes")
    return page


def camera(page: BrowserPage, name: str):
    return page.locator(f"t-camera[data-stream='eyes/{name}']")


def drawn(page: BrowserPage, name: str) -> np.ndarray:
    expect(camera(page, name).get_by_text("Live", exact=True)).to_be_visible(timeout=20_000)
    url = camera(page, name).locator("canvas").evaluate("canvas => canvas.toDataURL('image/png')")
    with Image.open(io.BytesIO(base64.b64decode(url.split(",")[1]))) as picture:
        return np.array(picture.convert("RGB"))


def picture_of(page: BrowserPage, name: str) -> None:
    """Keep a screenshot where a person asked for them."""
    folder = os.environ.get("TALAIA_PICTURES")
    if folder:
        page.screenshot(path=Path(folder) / f"{name}.png")


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
        expect(camera(page, name).get_by_text("cannot be shown")).to_be_visible(timeout=20_000)
        expect(camera(page, name).get_by_text(words)).to_be_visible()
    assert set(page.evaluate("window.__formats")) == {format_}
    picture_of(page, f"cameras-{format_}")
    assert stack.gateway.popen.poll() is None


def test_a_camera_is_looked_at_closely_and_kept(stack: Stack, chrome: Browser) -> None:
    page = opened(chrome, stack)
    drawn(page, "rgb8")
    one = camera(page, "rgb8")
    canvas = one.locator("canvas")
    lens = one.locator(".lens")
    box = lens.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 10, box["y"] + 10)
    page.mouse.wheel(0, -300)
    assert canvas.evaluate("each => each.style.transform") == ""
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
    with Image.open(kept.path()) as picture:
        assert picture.size == (320, 240)
        assert psnr(np.array(picture.convert("RGB")), scene(320, 240)) > 28
    one.get_by_role("button", name="Full screen").click()
    expect(one.get_by_role("button", name="Leave full screen")).to_be_visible()
    picture_of(page, "camera-full")
    one.get_by_role("button", name="Leave full screen").click()
    expect(one.get_by_role("button", name="Full screen", exact=True)).to_be_visible()
