"""Boxes in a real Chromium: they lie where the detector said, on the picture they belong to.

A scripted gateway sends pictures of a white bar that stands elsewhere on each one, and what is seen
on each second picture only later. The page itself notes, at each frame that it draws, which picture
is on the canvas (by the bar) and which one the box is of (by where it lies).
"""

from __future__ import annotations

import asyncio
import json
import os
import re
import time
from contextlib import asynccontextmanager
from pathlib import Path

import numpy as np
import pytest
import simplejpeg
from patience import PATIENCE_S, lasts_for
from playwright.async_api import expect

from talaia.model.detection import Detect, PictureLine, PictureZone
from talaia.wire import frames

from ..chromium import sign_in
from ..seeing import seeing

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]

FRONT = "camera/front"
SEEING = seeing(Detect(classes=("person", "dog")))
WIDTH, HEIGHT, BAR, STEP = 640, 480, 48, 4
PLACES = (WIDTH - BAR) // STEP
EVERY_S, LATE_S = 0.05, 0.12
# Which picture is on the canvas and which one its box is of, at each frame of the page.
NOTES = """
window.__notes = [];
const parts = (host) => host.shadowRoot;
const inside = (root, tag) => root && parts(root)?.querySelector(tag);
window.__look = () => {
  const walk = (root) => {
    for (const each of root.querySelectorAll('*')) {
      if (each.localName === 't-camera') return each;
      const found = each.shadowRoot && walk(each.shadowRoot);
      if (found) return found;
    }
    return null;
  };
  const camera = walk(document);
  const view = camera && inside(camera, 't-camera-view');
  const canvas = view && parts(view).querySelector('canvas');
  if (!canvas || canvas.width !== WIDTH) return null;
  const row = canvas.getContext('2d').getImageData(0, HEIGHT / 2, WIDTH, 1).data;
  let left = 0;
  while (left < WIDTH && row[left * 4] < 128) left += 1;
  const shown = canvas.getBoundingClientRect();
  const box = inside(view, 't-boxes') && parts(inside(view, 't-boxes')).querySelector('.box');
  const lies = box && box.getBoundingClientRect();
  return {
    bar: left,
    // In pixels of the picture, whatever the page makes of it.
    box: lies && (lies.left - shown.left) / shown.width * WIDTH,
    width: lies && lies.width / shown.width * WIDTH,
    top: lies && (lies.top - shown.top) / shown.height * HEIGHT,
    earlier: Boolean(box && box.classList.contains('earlier')),
  };
};
const note = () => {
  const seen = window.__look();
  if (seen) window.__notes.push(seen);
  window.__notes.splice(0, window.__notes.length - 3000);
  requestAnimationFrame(note);
};
requestAnimationFrame(note);
""".replace("WIDTH", str(WIDTH)).replace("HEIGHT", str(HEIGHT))  # fmt: skip


def place(seq: int) -> int:
    """Say where the bar of a picture begins (px)."""
    return seq % PLACES * STEP


def picture(seq: int) -> bytes:
    pixels = np.full((HEIGHT, WIDTH, 3), 20, np.uint8)
    pixels[:, place(seq) : place(seq) + BAR] = 250
    return simplejpeg.encode_jpeg(pixels, 95)


def boxes(seq: int) -> frames.DetectedBoxes:
    left = place(seq) / WIDTH
    bar = frames.DetectedObject(
        label="person", score=0.9, left=left, top=0.25, right=left + BAR / WIDTH, bottom=0.75
    )
    faint = frames.DetectedObject(label="dog", score=0.4, left=0, top=0, right=1, bottom=1)
    return frames.DetectedBoxes(stream=FRONT, seq=seq, time_us=seq * 50_000, things=[bar, faint])


@asynccontextmanager
async def filming(hub, gateway):
    """Let the camera film; each second picture is looked at, and that takes its time."""
    camera = await hub.camera()
    await gateway.hear(frames.StreamSubscription, lambda watch: watch.boxes == [FRONT])

    async def look(seq: int) -> None:
        await lasts_for(LATE_S)
        await camera.say(boxes(seq))

    async def film() -> None:
        seq = 0
        async with asyncio.TaskGroup() as looking:
            while True:
                seq += 1
                # The scripted gateway's clock is 5 ms ahead of the hub's.
                mono_us = time.monotonic_ns() // 1000 + 5_000
                await camera.say(
                    frames.PictureFrame(
                        stream=FRONT, seq=seq, time_us=seq * 50_000, mono_us=mono_us,
                        width=WIDTH, height=HEIGHT, data=picture(seq),
                    )
                )  # fmt: skip
                if seq % 2 == 0:
                    looking.create_task(look(seq))
                await asyncio.sleep(EVERY_S)

    task = asyncio.create_task(film())
    try:
        yield
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


async def watching(hub, chromium):
    gateway = await hub.gateway()
    await gateway.hello(SEEING)
    page = await sign_in(chromium, hub, "operator", script=NOTES, to="/sites/agv/devices/camera")
    return gateway, page


async def notes(page):
    """Give what was on screen, each thing once, in the order in which it was drawn."""
    seen = []
    for one in await page.evaluate("window.__notes"):
        if not seen or one != seen[-1]:
            seen.append(one)
    return seen


def behind(one) -> float:
    """Say by how many pictures the box is behind the one on the canvas."""
    steps = (one["bar"] - one["box"]) / STEP
    # The bar begins anew at the left.
    return steps + PLACES if steps < -PLACES / 2 else steps


def keep(page, name: str):
    """Keep a screenshot where a person asked for them."""
    folder = os.environ.get("TALAIA_PICTURES")
    return page.screenshot(path=Path(folder) / f"{name}.png") if folder else asyncio.sleep(0)


async def until(page, condition, what: str):
    """Look at what was drawn until it is so."""
    async with asyncio.timeout(PATIENCE_S):
        while not condition(await notes(page)):  # noqa: ASYNC110 - another process draws
            await asyncio.sleep(0.1)
    assert condition(await notes(page)), what


def looked_at(seen):
    """Give what was first on screen with each picture that the detector looked at."""
    firsts = [
        one
        for before, one in zip([{"bar": None}, *seen], seen, strict=False)
        if one["bar"] != before["bar"]
    ]
    return [one for one in firsts if one["bar"] // STEP % 2 == 0 and one["box"] is not None]


async def test_boxes_are_drawn_with_the_picture_they_belong_to(hub, chromium):
    gateway, page = await watching(hub, chromium)
    async with filming(hub, gateway):
        # Boxes come 120 ms late: if none waited for them, no picture would begin with its own.
        def together(seen):
            newest = looked_at(seen)[-20:]
            own = [one for one in newest if abs(behind(one)) < 0.5 and not one["earlier"]]
            return len(newest) == 20 and len(own) > 16

        await until(page, together, "pictures begin with their own boxes")
        strip = page.locator("t-objects")
        await expect(strip).to_contain_text("1 person")
        await expect(page.locator("t-camera .badge")).to_contain_text("Live")
        await keep(page, "boxes")
    boxed = [one for one in await notes(page) if one["box"] is not None]
    # A box is never of a picture that comes later.
    assert min(behind(one) for one in boxed) > -0.5
    assert {round(one["width"]) for one in boxed} <= {BAR - 1, BAR, BAR + 1}
    assert max(abs(one["top"] - HEIGHT / 4) for one in boxed) < 1.5


async def test_a_drivers_picture_never_waits_and_old_boxes_say_so(hub, chromium):
    gateway, page = await watching(hub, chromium)
    async with filming(hub, gateway):
        await expect(page.locator("t-objects")).to_contain_text("1 person")
        await page.locator("t-camera").evaluate("camera => { camera.driving = true }")
        await expect(page.get_by_role("button", name="Choose which objects")).to_have_count(0)
        await page.evaluate("window.__notes.length = 0")

        def prompt(seen):
            # Those that came late enough to stand on their own picture would be solid.
            newest = looked_at(seen)[-20:]
            return len(newest) == 20 and all(one["earlier"] for one in newest)

        await until(page, prompt, "boxes of earlier pictures are told apart")
        seen = looked_at(await notes(page))[-20:]
        # On a busy machine a picture may wait so long by itself that its own box is there.
        assert all(behind(one) > 1.5 for one in seen if one["earlier"])
        await keep(page, "boxes-driving")


async def test_boxes_stay_on_their_thing_when_the_picture_is_looked_at_closely(hub, chromium):
    gateway, page = await watching(hub, chromium)
    async with filming(hub, gateway):
        await expect(page.locator("t-boxes .box")).to_have_count(1)
        lens = page.locator("t-camera .lens")
        await lens.focus()
        await page.keyboard.press("+")
        await page.keyboard.press("+")
        await page.evaluate("window.__notes.length = 0")

        def enough(seen):
            return sum(one["box"] is not None for one in seen) >= 40

        await until(page, enough, "boxes are drawn on what is near")
        for one in await notes(page):
            if one["box"] is None:
                continue
            # Of this picture, or of one a moment before; and as large as its bar.
            assert -0.5 < behind(one) < 10
            assert abs(behind(one) - round(behind(one))) < 0.3
            assert abs(one["width"] - BAR) < 1.5
            assert abs(one["top"] - HEIGHT / 4) < 1.5
        await keep(page, "boxes-near")


async def test_what_is_framed_is_chosen_for_this_person_and_camera_and_kept(hub, chromium):
    gateway, page = await watching(hub, chromium)
    async with filming(hub, gateway):
        strip, frame = page.locator("t-objects"), page.locator("t-boxes .box")
        await expect(strip).to_contain_text("1 person")
        await page.get_by_role("button", name="Choose which objects").click()
        await page.get_by_role("slider").fill("40")
        await expect(strip).to_contain_text("1 dog")
        await page.get_by_role("checkbox", name="person").uncheck()
        await expect(frame).to_have_count(1)
        await expect(frame).to_have_attribute("data-label", "dog")
        await keep(page, "boxes-chosen")
        await page.keyboard.press("Escape")
        await expect(page.get_by_role("button", name="Choose which objects")).to_be_focused()
        await page.reload()
        await expect(strip).to_contain_text("1 dog")
        await expect(strip).not_to_contain_text("person")
        gateway.heard.clear()
        await page.get_by_role("button", name="Objects", exact=True).click()
        await gateway.hear(frames.StreamSubscription, lambda watch: not watch.boxes)
        await expect(frame).to_have_count(0)
    kept = await page.evaluate(
        "Object.entries(localStorage).find(([key]) => key.includes('objects'))"
    )
    assert json.loads(kept[1]) == {"on": False, "classes": ["dog"], "confidence": 0.4}
    assert '["operator","agv","camera/front"]' in kept[0]


async def test_zones_and_lines_stand_over_the_picture_until_they_are_hidden(hub, chromium):
    mat = PictureZone(name="Mat", points=((0.25, 0.5), (0.75, 0.5), (0.75, 1.0), (0.25, 1.0)))
    door = PictureLine(name="Door", points=((0.1, 0.9), (0.1, 0.3)))
    described = seeing(Detect(classes=("person",), zones={"mat": mat}, lines={"door": door}))
    counting = described.replace(
        "      front_person:",
        "      on_mat:\n        name: On the mat\n"
        "        source: {stream: front, sees: person, zone: mat}\n      front_person:",
        1,
    )
    gateway = await hub.gateway()
    await gateway.hello(counting)
    page = await sign_in(chromium, hub, "operator", to="/sites/agv/devices/camera")
    async with filming(hub, gateway):
        # No count has come: a dash, and no zero that could be believed.
        name = page.locator("t-picture-marks .name")
        await expect(name).to_have_text([re.compile(r"Mat\s+– person"), re.compile("Door")])
        shown = await page.locator("t-camera-view canvas").bounding_box()
        spot = await name.first.bounding_box()
        assert abs(spot["x"] + spot["width"] / 2 - shown["x"] - shown["width"] / 2) < 2
        assert abs(spot["y"] + spot["height"] / 2 - shown["y"] - shown["height"] * 0.75) < 2
        await keep(page, "marks")
        button = page.get_by_role("button", name="Zones and lines")
        await expect(button).to_have_attribute("aria-pressed", "true")
        await button.click()
        await expect(name).to_have_count(0)
        await page.reload()
        await expect(button).to_have_attribute("aria-pressed", "false")
        await expect(name).to_have_count(0)
