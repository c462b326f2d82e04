"""The product's pages in a real Chromium, measured from outside."""

from __future__ import annotations

import asyncio
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import numpy as np
from playwright.async_api import Page, async_playwright, expect
from stack import PASSWORD, Stack

# The tests' own list, which stands beside what finds their browser.
sys.path.append(str(Path(__file__).resolve().parent.parent / "tests"))
import browser_program

FLAGS, SPACE_FLAGS = browser_program.FLAGS, browser_program.SPACE_FLAGS

# Each paint leaves the age of the newest sample it drew, once the frame is on its way.
NOTE_PAINTS = """
window.__ages = [];
window.__talaiaPainted = (address, timeUs, value) => {
  requestAnimationFrame(() => {
    window.__ages.push(performance.timeOrigin + performance.now() - value / 1000);
  });
};
"""
NOTE_PICTURES = """
window.__pictured = [];
window.__talaiaPictured = (timeUs, format) => {
  const age = performance.timeOrigin + performance.now() - timeUs / 1000;
  window.__pictured.push([age, format]);
};
"""
NOTE_KEYS = """
window.__keys = [];
window.addEventListener('keydown', (event) => {
  if (!event.repeat) window.__keys.push((performance.timeOrigin + event.timeStamp) * 1000);
}, true);
"""
# Which charts have drawn samples up to a moment since the last click, and when the frame was on its
# way that had them all; ms after the click.
NOTE_DRAWN = """
window.__drawn = { all: 0, upTo: Infinity, seen: new Set(), clicked: 0, took: 0 };
window.addEventListener('click', (event) => {
  Object.assign(window.__drawn, { seen: new Set(), clicked: event.timeStamp, took: 0 });
}, true);
window.__talaiaPainted = (address, timeUs) => {
  const note = window.__drawn;
  if (timeUs < note.upTo || note.took > 0) return;
  note.seen.add(address);
  if (note.seen.size !== note.all) return;
  requestAnimationFrame(() => { note.took = performance.now() - note.clicked; });
};
"""


@asynccontextmanager
async def browser_page(
    script: str = "", height: int = 900, flags: list[str] = FLAGS
) -> AsyncIterator[Page]:
    """Open a page that trusts the hub's own certificate."""
    path = shutil.which("chromium") or shutil.which("google-chrome")
    clean = {k: v for k, v in os.environ.items() if k != "LD_LIBRARY_PATH"}
    async with async_playwright() as play:
        browser = await play.chromium.launch(executable_path=path, args=flags, env=clean)
        context = await browser.new_context(
            ignore_https_errors=True, viewport={"width": 1440, "height": height}
        )
        if script:
            await context.add_init_script(script)
        try:
            yield await context.new_page()
        finally:
            await browser.close()


async def sign_in(page: Page, stack: Stack, path: str) -> None:
    """Sign in and go to a page of the bench's site."""
    await page.goto(f"{stack.origin}/login")
    await page.get_by_label("Name").fill("admin")
    await page.get_by_label("Password").fill(PASSWORD)
    await page.get_by_role("button", name="Sign in", exact=True).click()
    await page.wait_for_url("**/home")
    await page.goto(f"{stack.origin}{path}")


async def process_seconds(page: Page) -> dict[str, float]:
    """Give the processor time of the browser's processes so far, by their kind."""
    assert page.context.browser is not None
    session = await page.context.browser.new_browser_cdp_session()
    found = await session.send("SystemInfo.getProcessInfo")
    await session.detach()
    used: dict[str, float] = {}
    for process in found["processInfo"]:
        used[process["type"]] = used.get(process["type"], 0.0) + process["cpuTime"]
    return used


async def painted(stack: Stack, seconds: float) -> np.ndarray:
    """Let the real-time page draw and give the ages (ms) of what it drew."""
    async with browser_page(NOTE_PAINTS) as page:
        await sign_in(page, stack, "/sites/bench/live")
        for _ in range(300):  # polling from inside is eval, which the pages forbid
            if await page.evaluate("window.__ages.length") > 50:
                break
            await asyncio.sleep(0.1)
        await asyncio.sleep(3)
        await page.evaluate("window.__ages = []")
        await asyncio.sleep(seconds)
        return np.array(await page.evaluate("window.__ages"))


async def filmed(stack: Stack, seconds: float, *, film: bool) -> np.ndarray:
    """Look at a camera; give the ages (ms) of pictures when they are on the canvas."""
    script = NOTE_PICTURES + ("" if film else "delete window.VideoDecoder;")
    async with browser_page(script) as page:
        await sign_in(page, stack, "/sites/bench/devices/base")
        await until_true(page, "window.__pictured.length > 30")
        await asyncio.sleep(4)
        await page.evaluate("window.__pictured = []")
        await asyncio.sleep(seconds)
        seen = await page.evaluate("window.__pictured")
    assert {form for _, form in seen} == {"h264" if film else "jpeg"}
    return np.array([age for age, _ in seen])


async def day_drawn(stack: Stack, charts: int, day_us: int, times: int) -> np.ndarray:
    """Click "Yesterday" on the history page; ms until all charts have drawn that day.

    The page shows a quarter of an hour of that day before each click. The window is so tall that
    every chart is on the screen: one that is not would not be drawn.
    """
    quarter = (day_us + 12 * 3_600_000_000, day_us + 12 * 3_600_000_000 + 900_000_000)
    asked = "&".join(f"c=base/s{each}" for each in range(charts))
    path = f"/sites/bench/history?{asked}&from={quarter[0]}&to={quarter[1]}"
    took = []
    async with browser_page(NOTE_DRAWN, height=1000 + charts * 470) as page:
        await sign_in(page, stack, path)
        for _ in range(times):
            await expect(page.locator("t-history-chart canvas")).to_have_count(charts)
            await page.locator(".charts[aria-busy=false]").wait_for()
            await asyncio.sleep(1)  # until nothing of what was before is under way
            # Later than all that the page has loaded so far, margins and all.
            end = day_us + 86_400_000_000 - 600_000_000
            await page.evaluate(f"Object.assign(window.__drawn, {{all: {charts}, upTo: {end}}})")
            await page.get_by_label("Yesterday").click()
            await until_true(page, "window.__drawn.took > 0")
            took.append(float(await page.evaluate("window.__drawn.took")))
            await page.evaluate("window.__drawn.upTo = Infinity")
            await page.go_back()
    return np.array(took)


async def until_true(page: Page, true: str) -> None:
    """Wait until something is true in a page."""
    for _ in range(1500):  # polling from inside is eval, which the pages forbid
        if await page.evaluate(true):
            return
        await asyncio.sleep(0.02)
    raise SystemExit(f"the page did not come so far within 30 s: {true}")


async def pressed(stack: Stack, target: Path, presses: int) -> np.ndarray:
    """Press keys on the actuate page and give the time (ms) until each reached ROS."""
    ages = []
    chance = random.Random(1)  # noqa: S311 - of a benchmark
    async with browser_page(NOTE_KEYS) as page:
        await sign_in(page, stack, "/sites/bench/drive")
        await page.get_by_role("button", name="Take control").click()
        await page.get_by_text("You have control").first.wait_for()
        for each in range(presses + 20):
            known = len(target.read_text().splitlines())
            await page.keyboard.down("w")
            at = await page.evaluate("window.__keys.at(-1)")
            line = await _first_moving(target, known)
            await page.keyboard.up("w")
            await _standing(target)
            # A quick hand's pace, in no step with any timer; faster, the gateway's limit of the
            # rate to the robot would be measured.
            await asyncio.sleep(chance.uniform(0.06, 0.16))
            if each >= 20:  # the first ones warm up
                ages.append((float(line.split()[0]) - at) / 1000)
    return np.array(ages)


async def _first_moving(target: Path, known: int) -> str:
    for _ in range(2000):
        for line in target.read_text().splitlines()[known:]:
            if float(line.split()[1]) > 0:
                return line
        await asyncio.sleep(0.002)
    raise SystemExit("a key press did not reach ROS within 4 s")


async def _standing(target: Path) -> None:
    for _ in range(2000):
        lines = target.read_text().splitlines()
        if lines and float(lines[-1].split()[1]) == 0:
            return
        await asyncio.sleep(0.002)
    raise SystemExit("the vehicle was not stopped within 4 s of the release")


async def first_paint(stack: Stack) -> tuple[float, float]:
    """Give kB of JavaScript over the wire for sign-in and home, and ms to the first paint."""
    weights: dict[str, int] = {}
    async with browser_page() as page:
        session = await page.context.new_cdp_session(page)
        await session.send("Network.enable")
        scripts: dict[str, str] = {}

        def responded(event: dict) -> None:
            if "javascript" in event["response"]["mimeType"]:
                scripts[event["requestId"]] = event["response"]["url"]

        def finished(event: dict) -> None:
            if event["requestId"] in scripts:
                url = scripts[event["requestId"]]  # the second page load takes it from the cache
                weights[url] = max(weights.get(url, 0), event["encodedDataLength"])

        session.on("Network.responseReceived", responded)
        session.on("Network.loadingFinished", finished)
        await sign_in(page, stack, "/home")
        await page.get_by_role("heading", name="Bench").first.wait_for()
        paint = await page.evaluate(
            "performance.getEntriesByName('first-contentful-paint')[0].startTime"
        )
    return sum(weights.values()) / 1000, float(paint)


def demo_seconds() -> float:
    """Start the demo, give the seconds it says it took, and stop it."""
    process = subprocess.Popen(
        [sys.executable, "-m", "talaia", "demo", "--no-browser"],
        stdout=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    alarm = threading.Timer(60, process.kill)
    alarm.start()
    seconds = float("nan")
    assert process.stdout is not None
    for line in process.stdout:
        found = re.search(r"ready \(([\d.]+) s\)", line)
        if found:
            seconds = float(found[1])
        if "Ctrl-C" in line:
            break
    alarm.cancel()
    process.send_signal(signal.SIGINT)
    process.wait(20)
    process.stdout.close()
    return seconds


@asynccontextmanager
async def demo_running(data: Path) -> AsyncIterator[tuple[str, str]]:
    """Run the demo in a folder; give its address and its operator's password."""
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "talaia", "demo", "--no-browser", "--data", str(data),
        stdout=asyncio.subprocess.PIPE, start_new_session=True,
    )  # fmt: skip
    try:
        assert process.stdout is not None
        words = ""
        async with asyncio.timeout(60):
            while "Ctrl-C" not in words:
                line = (await process.stdout.readline()).decode()
                words += line
                if not line:
                    raise SystemExit(f"the demo ended at its start:\n{words}")
        address = re.search(r"https?://\S+", words)
        password = re.search(r"operator\s+(\S+)", words)
        if not address or not password:
            raise SystemExit(f"the demo did not greet as expected:\n{words}")
        yield address[0], password[1]
    finally:
        process.send_signal(signal.SIGINT)
        await process.wait()


async def pressed_in_demo(data: Path, presses: int) -> np.ndarray:
    """Turn the demo's vehicle by keys, its camera shown; ms until it took each command."""
    ages = []
    chance = random.Random(1)  # noqa: S311 - of a benchmark
    log = data / "actuations.jsonl"
    async with demo_running(data) as (address, password), browser_page(NOTE_KEYS) as page:
        await page.goto(f"{address}/login")
        await page.get_by_label("Name").fill("operator")
        await page.get_by_label("Password").fill(password)
        await page.get_by_role("button", name="Sign in", exact=True).click()
        await page.wait_for_url("**/home")
        await page.goto(f"{address}/sites/agv/drive")
        await page.get_by_role("button", name="Take control").click()
        await page.get_by_text("You have control").first.wait_for()
        await page.get_by_text("Live", exact=True).first.wait_for()
        await asyncio.sleep(3)
        for each in range(presses + 20):
            known = len(log.read_text().splitlines())
            key = "ad"[each % 2]  # turning on the spot, to and fro: it never meets a wall
            await page.keyboard.down(key)
            at = await page.evaluate("window.__keys.at(-1)")
            line = await _turned(log, known, moving=True)
            await page.keyboard.up(key)
            await _turned(log, known, moving=False)
            await asyncio.sleep(chance.uniform(0.06, 0.16))
            if each >= 20:
                ages.append((line["wall_ns"] / 1000 - at) / 1000)
    return np.array(ages)


async def _turned(log: Path, known: int, *, moving: bool) -> dict[str, float]:
    for _ in range(2000):
        lines = log.read_text().rpartition("\n")[0].splitlines()[known:]
        for line in lines if moving else lines[-1:]:
            change: dict[str, float] = json.loads(line)
            if (change["w"] != 0) is moving:
                return change
        await asyncio.sleep(0.002)
    raise SystemExit("the demo's vehicle did not follow the key within 4 s")
