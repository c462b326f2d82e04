"""What models tell, in a real Chromium: drawn where it is, told in words, gone when it is old."""

from __future__ import annotations

import asyncio
import os
import time
from contextlib import asynccontextmanager
from pathlib import Path

import numpy as np
import pytest
import simplejpeg
from playwright.async_api import expect

from talaia.model.picture_models.picture_model import COCO_POINTS
from talaia.wire import frames

from ..chromium import sign_in
from ..modelled import modelled

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]

FRONT = "camera/front"
WIDTH, HEIGHT = 640, 480
NOTHING = frames.OverlayLayer(rows=0, columns=0, runs=b"", near=None, far=None, poses=[], likely=[])


def layer_of(cells: np.ndarray, near: float | None = None, far: float | None = None):
    runs = np.stack([np.ones(cells.size, np.uint8), cells.ravel()], axis=1).astype(np.uint8)
    return frames.OverlayLayer(
        rows=cells.shape[0], columns=cells.shape[1], runs=runs.tobytes(),
        near=near, far=far, poses=[], likely=[],
    )  # fmt: skip


def layers() -> dict[str, frames.OverlayLayer]:
    """Floor below, a wall at the left; a person in the middle; near at the right."""
    ground = np.zeros((12, 16), np.uint8)
    ground[6:], ground[:6, :4] = 1, 2
    depth = np.tile(np.arange(16, dtype=np.uint8), (12, 1))
    points = [(0.5, 0.2 + number / 30, 0.9) for number in range(len(COCO_POINTS))]
    pose = frames.DetectedPose(score=0.9, left=0.4, top=0.2, right=0.6, bottom=0.9, points=points)
    hall = frames.ClassLikelihood(label="hall", share=0.93)
    copy = {"rows": 0, "columns": 0, "runs": b"", "near": None, "far": None}
    return {
        "ground": layer_of(ground),
        "far": layer_of(depth, 0.84, 6.2),
        "pose": frames.OverlayLayer(**copy, poses=[pose], likely=[]),
        "room": frames.OverlayLayer(**copy, poses=[], likely=[hall]),
    }


@asynccontextmanager
async def filming(hub, *, telling: bool = True):
    """Let the camera film, and its models tell of each picture."""
    camera = await hub.camera()
    # Of a picture without any contrast the page would say that the lens is covered.
    pixels = np.full((HEIGHT, WIDTH, 3), 90, np.uint8)
    pixels[:, WIDTH // 2 :] = 210
    picture = simplejpeg.encode_jpeg(pixels, 90)
    said = layers()

    async def film() -> None:
        for seq in range(1, 100_000):
            mono_us = time.monotonic_ns() // 1000 + 5_000
            shot = frames.PictureFrame(
                stream=FRONT, seq=seq, time_us=seq * 100_000, mono_us=mono_us,
                width=WIDTH, height=HEIGHT, data=picture,
            )  # fmt: skip
            await camera.say(shot)
            for model, layer in said.items() if telling else ():
                overlay = frames.ModelOverlay(
                    stream=FRONT, seq=seq, time_us=seq * 100_000, model=model, layer=layer
                )
                await camera.say(overlay)
            await asyncio.sleep(0.1)

    task = asyncio.create_task(film())
    try:
        yield
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


async def watching(hub, chromium, **size):
    gateway = await hub.gateway()
    await gateway.hello(modelled())
    page = await sign_in(chromium, hub, "operator")
    if size:
        await page.set_viewport_size(size)
    await page.goto(f"{hub.origin}/sites/agv/devices/camera")
    return gateway, page


def keep(page, name: str):
    """Keep a screenshot where a person asked for them."""
    folder = os.environ.get("TALAIA_PICTURES")
    return page.screenshot(path=Path(folder) / f"{name}.png") if folder else asyncio.sleep(0)


def painted(page, model: str, x: float, y: float):
    """Give the colour of a cell of a model's map (red, green, blue, how opaque)."""
    script = """(canvas, [x, y]) => [...canvas.getContext('2d').getImageData(
        Math.floor(x * canvas.width), Math.floor(y * canvas.height), 1, 1).data]"""
    return page.locator(f"t-model-overlay canvas[data-model={model}]").evaluate(script, [x, y])


async def test_areas_people_and_rooms_are_drawn_and_told_and_depth_only_when_asked(hub, chromium):
    gateway, page = await watching(hub, chromium)
    async with filming(hub):
        await gateway.hear(frames.StreamSubscription, lambda watch: watch.overlays == [FRONT])
        strip, overlay = page.locator("t-models"), page.locator("t-model-overlay")
        # Never by colour alone: names on the picture, names with shares in the legend.
        await expect(overlay.locator(".name[data-name=floor]")).to_be_visible()
        await expect(strip).to_contain_text("floor 50")
        await expect(strip).to_contain_text("wall 13")
        await expect(strip).not_to_contain_text("other")
        await expect(strip).to_contain_text("hall 93")
        await expect(strip).to_contain_text("person")
        await expect(overlay.locator(".name", has_text="person 90")).to_be_visible()
        await expect(overlay.locator("line.bone")).to_have_count(16)
        floor, wall, other = [
            await painted(page, "ground", *at) for at in ((0.6, 0.9), (0.1, 0.2), (0.8, 0.2))
        ]
        assert floor[3] == wall[3] == 255
        assert floor != wall
        assert other[3] == 0
        await expect(overlay.locator("canvas[data-model=far]")).to_have_count(0)
        await keep(page, "models")
        await page.get_by_role("button", name="far", exact=True).click()
        await expect(strip).to_contain_text("bright is near, 0.8")
        far, near = await painted(page, "far", 0.01, 0.5), await painted(page, "far", 0.99, 0.5)
        assert far[3] < 20 < 240 < near[3]
        # The map lies on the picture, and nowhere beside it.
        canvas = await overlay.locator("canvas[data-model=ground]").bounding_box()
        view = await page.locator("t-camera-view").bounding_box()
        assert canvas["width"] / canvas["height"] == pytest.approx(4 / 3, abs=0.02)
        assert abs(canvas["x"] + canvas["width"] / 2 - view["x"] - view["width"] / 2) < 2
        await keep(page, "models-depth")


async def test_models_are_switched_off_for_this_person_and_nothing_is_sent_then(hub, chromium):
    gateway, page = await watching(hub, chromium)
    async with filming(hub):
        strip = page.locator("t-models")
        await expect(strip).to_contain_text("hall 93")
        gateway.heard.clear()
        for model in ("ground", "room", "pose"):
            await page.get_by_role("button", name=model, exact=True).click()
        await gateway.hear(frames.StreamSubscription, lambda watch: not watch.overlays)
        await expect(strip).not_to_contain_text("hall")
        await expect(page.locator("t-model-overlay")).to_have_count(0)
        await page.reload()
        button = page.get_by_role("button", name="ground", exact=True)
        await expect(button).to_have_attribute("aria-pressed", "false")
        await button.click()
        await expect(strip).to_contain_text("floor 50")
        await expect(strip).not_to_contain_text("hall")


async def test_what_is_old_is_not_drawn_and_a_silent_model_is_called_so(hub, chromium):
    _, page = await watching(hub, chromium)
    strip = page.locator("t-models")
    async with filming(hub, telling=False):
        await expect(strip).to_contain_text("waiting for the model")
    async with filming(hub):
        await expect(strip).to_contain_text("floor 50")
    async with filming(hub, telling=False):
        await expect(page.locator("t-model-overlay")).to_have_count(0)
        await expect(strip).to_contain_text("the model is silent", timeout=20_000)


async def test_models_have_room_on_a_phone(hub, chromium):
    _, page = await watching(hub, chromium, width=390, height=844)
    async with filming(hub):
        await expect(page.locator("t-models")).to_contain_text("hall 93")
        await expect(page.locator("t-model-overlay .name").first).to_be_visible()
        wide = await page.evaluate("document.documentElement.scrollWidth")
        assert wide <= 390
        await keep(page, "models-phone")
