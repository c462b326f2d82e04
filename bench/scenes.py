"""A robot in space, in Talaia's page and in a bare one of three.js, by turns in one Chromium."""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
import time
from collections.abc import AsyncIterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pages
import taps
from playwright.async_api import Page
from stack import Stack, free_port

HERE = Path(__file__).resolve().parent
LINKS = 30
TOPICS = ["/bench/tf", "/bench/scan", "/bench/cloud"]
# Frames drawn, and the age of each layer once the frame that had it first is on its way.
NOTE_SCENE = """
window.__scene = { painted: 0, ages: {} };
window.__talaiaSceneDrawn = (news) => {
  window.__scene.painted += 1;
  if (news.length === 0) return;
  requestAnimationFrame(() => {
    const now = performance.timeOrigin + performance.now();
    for (const [topic, us] of news) (window.__scene.ages[topic] ??= []).push(now - us / 1000);
  });
};
"""


class Seen(NamedTuple):
    """What one page drew in one round.

    Attributes:
        frames: a second.
        scan_ms: age of each scan when it was painted.
        clouds: a second.
        page: what its process used, percent of a core.
        frame_ms: processor time of a frame, of the page's process and the one that draws in
            software.

    """

    frames: float
    scan_ms: np.ndarray
    clouds: float
    page: float
    frame_ms: float


@contextlib.asynccontextmanager
async def robot(here: Stack, *words: str) -> AsyncIterator[None]:
    """Run the robot of scenes beside a stack."""
    async with _python(here, "scene_robot.py", "600", *words):
        yield


@contextlib.asynccontextmanager
async def bare_server(here: Stack, *, cloud: bool, size: tuple[int, int]) -> AsyncIterator[str]:
    """Serve the yardstick; gives its address."""
    port = free_port()
    words = [str(port), *map(str, size), str(LINKS), *(["--cloud"] if cloud else [])]
    async with _python(here, "bare_scene.py", *words):
        yield f"http://localhost:{port}/"


@contextlib.asynccontextmanager
async def _python(here: Stack, name: str, *words: str) -> AsyncIterator[None]:
    process = await asyncio.create_subprocess_exec(
        sys.executable, str(HERE / name), *words,
        stdout=asyncio.subprocess.PIPE, env={**os.environ, **here.environment},
    )  # fmt: skip
    try:
        assert process.stdout is not None
        if await asyncio.wait_for(process.stdout.readline(), 30) != b"ready\n":
            raise SystemExit(f"{name} did not come up")
        yield
    finally:
        process.kill()
        await process.wait()


async def look(page: Page, seconds: float) -> Seen:
    """Measure a page that draws."""
    for _ in range(400):  # polling from inside is eval, which the pages forbid
        if await page.evaluate("window.__scene.painted > 30"):
            break
        await asyncio.sleep(0.05)
    await asyncio.sleep(2)
    await page.evaluate("window.__scene = { painted: 0, ages: {} }")
    before, began = await pages.process_seconds(page), time.monotonic()
    await asyncio.sleep(seconds)
    found = await page.evaluate("window.__scene")
    took = time.monotonic() - began
    used = await pages.process_seconds(page)
    return Seen(
        found["painted"] / took,
        np.array(found["ages"].get("/bench/scan", [])),
        len(found["ages"].get("/bench/cloud", [])) / took,
        100 * (used["renderer"] - before["renderer"]) / took,
        1000
        * sum(used[kind] - before[kind] for kind in ("renderer", "GPU"))
        / max(1, found["painted"]),
    )


async def side_by_side(
    here: Stack, *, cloud: bool, rounds: int, seconds: float
) -> tuple[list[Seen], list[Seen]]:
    """Look at the robot in Talaia's page and in the bare one, in turn."""
    ours, bare = [], []
    async with pages.browser_page(NOTE_SCENE, flags=pages.SPACE_FLAGS) as page:
        await pages.sign_in(page, here, "/home")
        for _ in range(rounds):
            await page.goto(f"{here.origin}/sites/bench/scene")
            canvas = page.locator("t-scene canvas")
            await canvas.wait_for()
            if cloud:
                await page.locator("input[data-topic='/bench/cloud']").check()
            ours.append(await look(page, seconds))
            box = await canvas.bounding_box()
            smooth = await canvas.evaluate(
                "(one) => one.getContext('webgl2').getContextAttributes().antialias"
            )
            assert box is not None
            # A page that is gone takes nothing of the machine from the other.
            await page.goto("about:blank")
            size = round(box["width"]), round(box["height"])
            async with bare_server(here, cloud=cloud, size=size) as address:
                await page.goto(address + ("" if smooth else "?plain"))
                bare.append(await look(page, seconds))
                await page.goto("about:blank")
            for name, each in (("ours", ours), ("bare", bare)):
                print("  ", name, [round(float(np.median(x)), 1) for x in each[-1]], flush=True)
    return ours, bare


async def heard_elsewhere(here: Stack) -> tuple[int, int]:
    """Count subscriptions on the robot while its scene is looked at, and from another page."""
    async with pages.browser_page(NOTE_SCENE, flags=pages.SPACE_FLAGS) as page:
        await pages.sign_in(page, here, "/sites/bench/scene")
        await page.locator("t-scene canvas").wait_for()
        await page.locator("input[data-topic='/bench/cloud']").check()
        await look(page, 1)
        while_looking = await asyncio.to_thread(taps.subscriptions, here, TOPICS)
        await page.get_by_role("link", name="Home").first.click()
        await page.wait_for_url("**/home")
        await asyncio.sleep(1)
        return while_looking, await asyncio.to_thread(taps.subscriptions, here, TOPICS)
