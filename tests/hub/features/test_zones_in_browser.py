"""Zones and lines are drawn over the picture in a real Chromium, and the gateway goes by them."""

from __future__ import annotations

import asyncio
import os
import re
import time
from pathlib import Path

import numpy as np
import pytest
import simplejpeg
from page_accessibility import find_violations
from playwright.async_api import expect

from talaia.model.detection import Measured
from talaia.model.yaml_text.load import dump_site, load_site
from talaia.wire.frames import (
    ChangePhase,
    ChangeRequest,
    ChangeState,
    DescriptionUpdate,
    Hello,
    PictureFrame,
    StreamSubscription,
    Welcome,
)
from talaia.wire.sealing import compress_text, decompress_text, digest_of

from ..chromium import sign_in
from .test_pages_in_browser import WIDTH

pytestmark = [pytest.mark.browser, pytest.mark.timeout(400)]

HALL = """# The hall.
talaia: 1
site: agv
name: Hall
ros2: {}
devices:
  camera:
    name: Camera
    streams:
      front:
        name: Front camera
        source: {topic: /images, type: sensor_msgs/msg/Image}
        detect: {classes: [person, dog]}  # nobody else comes here
    signals: {}
"""


def described(text: str) -> dict[str, object]:
    return {
        "description": dump_site(load_site(text)),
        "catalogue": digest_of(text)[:8],
        "source": compress_text(text),
    }


async def film(camera) -> None:
    """Send a picture of a hall again and again."""
    pixels = np.zeros((480, 640, 3), np.uint8)
    pixels[:, :, 0] = np.linspace(60, 160, 640, dtype=np.uint8)
    pixels[240:, :, 1:] = 120
    jpeg, seq = simplejpeg.encode_jpeg(pixels, 80), 0
    while True:
        seq += 1
        mono_us = time.monotonic_ns() // 1000 + 5_000
        await camera.say(
            PictureFrame(
                stream="camera/front", seq=seq, time_us=seq * 200_000, mono_us=mono_us,
                width=640, height=480, data=jpeg,
            )
        )  # fmt: skip
        await asyncio.sleep(0.2)


async def apply_change(gateway) -> str:
    """Go by what the hub hands over; give its text."""
    asked = await gateway.hear(ChangeRequest)
    text = decompress_text(asked.source)
    site = load_site(text)
    await gateway.say(
        DescriptionUpdate(
            description=compress_text(dump_site(site)),
            catalogue=digest_of(text)[:8],
            addresses=[each.address for each in site.channels()],
            source=compress_text(text),
            id=asked.id,
            who="admin",
        )
    )
    await gateway.say(ChangeState(id=asked.id, phase=ChangePhase.APPLIED))
    return text


async def keep(page, name: str) -> None:
    """Keep screenshots of desktop and phone, light and dark, where a person asked for them."""
    folder = os.environ.get("TALAIA_PICTURES")
    if not folder:
        return
    for width in (1440, 390):
        await page.set_viewport_size({"width": width, "height": 900})
        for scheme in ("light", "dark"):
            await page.emulate_media(color_scheme=scheme)
            path = Path(folder) / f"{name}-{width}-{scheme}.png"
            await page.screenshot(path=path)
    await page.set_viewport_size({"width": 1440, "height": 900})
    await page.emulate_media(color_scheme="light")


async def test_an_admin_draws_a_zone_and_a_line_and_the_gateway_goes_by_them(hub, chromium):
    gateway = await hub.gateway()
    await gateway.say(Hello(site="agv", boot="boot-1", accepts="readings", **described(HALL)))
    await gateway.hear(Welcome)
    camera = await hub.camera()
    page = await sign_in(chromium, hub, "admin", to="/sites/agv/zones?camera=camera/front")
    await expect(page.get_by_text("Nothing is drawn yet")).to_be_visible()
    await gateway.hear(StreamSubscription)
    filming = asyncio.create_task(film(camera))
    try:
        await expect(page.locator("t-camera .badge")).to_contain_text("Live")
        apply = page.get_by_role("button", name="Review and apply")
        await expect(apply).to_be_disabled()

        await page.get_by_role("button", name="Add zone").click()
        point = page.get_by_role("button", name=re.compile("^Point 1 of 4 of Zone 1: 35.0 %"))
        # By keyboard: the new point has the focus.
        await expect(point).to_be_focused()
        await page.keyboard.press("Shift+ArrowLeft")
        await page.keyboard.press("ArrowDown")
        moved = re.compile("^Point 1 of 4 of Zone 1: 30.0 % from the left, 35.5 %")
        await expect(page.get_by_role("button", name=moved)).to_be_focused()
        await page.keyboard.press("+")
        await expect(page.get_by_role("button", name=re.compile("^Point 2 of 5"))).to_be_focused()
        await page.keyboard.press("Delete")
        await expect(page.get_by_role("button", name=re.compile("^Point 1 of 4"))).to_be_visible()

        # By pointer: a corner goes where it is dropped.
        shown = await page.locator("t-shape-handles").bounding_box()
        corner = page.get_by_role("button", name=re.compile("^Point 3 of 4 of Zone 1"))
        held = await corner.bounding_box()
        await page.mouse.move(held["x"] + held["width"] / 2, held["y"] + held["height"] / 2)
        await page.mouse.down()
        to = (shown["x"] + 0.9 * shown["width"], shown["y"] + 0.8 * shown["height"])
        await page.mouse.move(*to, steps=6)
        await page.mouse.up()
        dropped = re.compile(
            "^Point 3 of 4 of Zone 1: (90.0|89.9|90.1) % from the left, (80.0|79.9|80.1) %"
        )
        await expect(page.get_by_role("button", name=dropped)).to_be_visible()

        await page.get_by_label("Zone, name").fill("Charging place")
        await page.get_by_role("button", name="Add line").click()
        await page.get_by_role("button", name=re.compile("Reverse the direction")).click()
        await page.get_by_role("button", name="Undo").click()
        await page.get_by_role("button", name="Redo").click()
        await page.get_by_label("Line, name").fill("")
        await expect(apply).to_be_disabled()
        await page.get_by_label("Line, name").fill("Door")
        assert await find_violations(page) == []
        await page.set_viewport_size({"width": 390, "height": 900})
        assert await page.evaluate(WIDTH) <= 390
        await page.set_viewport_size({"width": 1440, "height": 900})
        await keep(page, "zones-drawn")

        await apply.click()
        dialog = page.get_by_role("dialog")
        await expect(dialog).to_contain_text("zones")
        await keep(page, "zones-review")
        going = asyncio.create_task(apply_change(gateway))
        await page.get_by_role("button", name="Apply", exact=True).click()
        text = await going
        await expect(dialog).to_be_hidden()
        # What counts at them is there at once, and waits for its first value.
        await expect(page.locator("t-shape-list")).to_contain_text("\u2013 person")
        await keep(page, "zones-applied")
    finally:
        filming.cancel()
        await asyncio.gather(filming, return_exceptions=True)

    # Comments stay, and the rest is as it was drawn.
    assert text.startswith("# The hall.")
    assert "# nobody else comes here" in text
    front = load_site(text).devices["camera"]
    detect = front.streams["front"].detect
    zone, line = detect.zones["charging_place"], detect.lines["door"]
    assert (zone.name, line.name) == ("Charging place", "Door")
    assert zone.points[0] == (0.3, 0.355)
    assert zone.points[2] == pytest.approx((0.9, 0.8), abs=0.002)
    assert line.points == ((0.7, 0.5), (0.3, 0.5))
    counted = {
        name: (signal.source.zone or signal.source.line, signal.source.measure)
        for name, signal in front.signals.items()
    }
    assert counted == {
        "charging_place_count": ("charging_place", Measured.COUNT),
        "charging_place_dwell": ("charging_place", Measured.DWELL),
        "door_left": ("door", Measured.LEFT),
        "door_right": ("door", Measured.RIGHT),
    }
    assert page.errors == []


async def test_who_is_no_admin_draws_nothing(hub, chromium):
    gateway = await hub.gateway()
    await gateway.hello(HALL)
    page = await sign_in(chromium, hub, "operator", to="/sites/agv/zones")
    await expect(page.get_by_text("This page is for admins of the site")).to_be_visible()
    await expect(page.get_by_role("button", name="Add zone")).to_have_count(0)
    await keep(page, "zones-forbidden")
    assert page.errors == []
