"""A board of many live tiles, and many sites on one page, in a real Chromium."""

from __future__ import annotations

import asyncio
import time
from typing import Any, NamedTuple

import httpx
import numpy as np
import pages
from clients import cookie
from playwright.async_api import Page
from stack import Stack, context

TILES = 40
# Kinds of tiles, with their signals; columns and rows of each, so that all are on one screen.
KINDS = (("value", 1, 2, 2), ("chart", 1, 3, 3), ("gauge", 1, 3, 3), ("table", 4, 3, 3))
COUNTS = {"value": 18, "chart": 12, "gauge": 8, "table": 2}
# Three rows of values, three of charts, two of gauges and half a one of tables, with the page's
# head.
HEIGHT = 1700
# From a message on the page's socket to the frame after its charts were drawn; and of each message
# to the frame after it was handled, by when all that is no chart is drawn. Of charts are the
# subscriptions that the page asked for 20 times a second; what comes for values five times a second
# would wait for the charts' next samples. A message with samples is never so small as what is said
# of the time.
NOTE_BOARD = """
(() => {
  const note = { charts: [], rest: [], clicked: 0, dataAt: 0, drawn: 0, seen: new Set(), all: 0 };
  window.__board = note;
  const ofCharts = new Set();
  let waiting = [];
  let news = false;
  // The whole number behind a key of MessagePack; -1 without.
  const numberOf = (bytes, key) => {
    const sign = [0xa0 + key.length, ...new TextEncoder().encode(key)];
    const at = bytes.findIndex((_, i) => sign.every((one, j) => bytes[i + j] === one));
    const [kind, high, low] = bytes.subarray(at + sign.length);
    if (at < 0) return -1;
    return kind < 0x80 ? kind : kind === 0xcc ? high : kind === 0xcd ? 256 * high + low : -1;
  };
  const Plain = window.WebSocket;
  window.WebSocket = class extends Plain {
    constructor(...words) {
      super(...words);
      this.addEventListener('message', (event) => {
        if ((event.data.byteLength ?? 0) < 200) return;
        const at = event.timeStamp;
        if (note.dataAt === 0) note.dataAt = at;
        news = true;
        if (ofCharts.has(numberOf(new Uint8Array(event.data, 0, 64), 'sub'))) waiting.push(at);
        const noteRest = () => note.rest.push(performance.now() - at);
        requestAnimationFrame(() => requestAnimationFrame(noteRest));
      });
    }
    send(bytes) {
      if (numberOf(bytes, 'every_ms') === 50) ofCharts.add(numberOf(bytes, 'sub'));
      super.send(bytes);
    }
  };
  window.__talaiaPainted = (address) => {
    note.seen.add(address);
    if (!news) return;
    const drawn = waiting;
    waiting = [];
    news = false;
    requestAnimationFrame(() => {
      const now = performance.now();
      note.charts.push(...drawn.map((at) => now - at));
      if (note.drawn === 0 && note.seen.size >= note.all) note.drawn = now;
    });
  };
  window.addEventListener('click', (event) => {
    Object.assign(note, { clicked: event.timeStamp, dataAt: 0, drawn: 0, seen: new Set() });
  }, true);
})();
"""
# The longest pause between two frames while a page is scrolled (ms).
NOTE_FRAMES = """
window.__frames = [];
(() => {
  let before = performance.now();
  const tick = (now) => {
    window.__frames.push(now - before);
    before = now;
    requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
})();
"""


class Opened(NamedTuple):
    """How soon a page was there (ms), and its longest pause while it was scrolled."""

    first_paint: float
    listed: float
    pauses: np.ndarray


def board_of_tiles() -> dict[str, Any]:
    """Arrange 40 tiles of 44 signals."""
    tiles: list[dict[str, Any]] = []
    signal, x, y = 0, 0, 0
    for kind, signals, wide, high in KINDS:
        for _ in range(COUNTS[kind]):
            if x + wide > 12:
                x, y = 0, y + high
            names = [f"base/s{signal + each}" for each in range(signals)]
            signal += signals
            many = kind in ("chart", "table")
            tiles.append(
                {
                    "id": f"t{len(tiles)}", "type": kind, "title": "",
                    "settings": {"signals": names} if many else {"signal": names[0]},
                    "desktop": {"x": x, "y": y, "w": wide, "h": high}, "phone": None,
                }
            )  # fmt: skip
            x += wide
        x, y = 0, y + high
    assert len(tiles) == TILES
    return {"name": "Bench", "note": "", "site": "bench", "kind": "", "device": "", "tiles": tiles}


SIGNALS = sum(COUNTS[kind] * signals for kind, signals, _, _ in KINDS)


async def keep_board(here: Stack, board: dict[str, Any]) -> str:
    """Keep a board; give its key."""
    headers = {"Origin": here.origin, "Cookie": await cookie(here)}
    async with httpx.AsyncClient(
        verify=context(here), base_url=here.origin, timeout=60, headers=headers
    ) as client:
        answer = await client.post("/api/boards", json={"board": board, "note": ""})
        answer.raise_for_status()
        return str(answer.json()["key"])


async def page_percent(here: Stack, key: str, seconds: float) -> list[float]:
    """Give what the page's process uses of a core with the board open; nothing is noted in it."""
    async with pages.browser_page(height=HEIGHT) as page:
        await pages.sign_in(page, here, f"/boards/{key}")
        await page.locator("t-chart canvas").first.wait_for()
        await asyncio.sleep(4)
        found = []
        for _ in range(3):
            before, began = await pages.process_seconds(page), time.monotonic()
            await asyncio.sleep(seconds)
            used = (await pages.process_seconds(page))["renderer"] - before["renderer"]
            found.append(100 * used / (time.monotonic() - began))
        return found


async def socket_to_paint(here: Stack, key: str, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Give ms from a message on the page's socket to its charts' frame, and to the rest's."""
    async with pages.browser_page(NOTE_BOARD, height=HEIGHT) as page:
        await pages.sign_in(page, here, f"/boards/{key}")
        await page.locator("t-chart canvas").first.wait_for()
        await asyncio.sleep(4)
        await page.evaluate("Object.assign(window.__board, { charts: [], rest: [] })")
        await asyncio.sleep(seconds)
        found = await page.evaluate("[window.__board.charts, window.__board.rest]")
        return np.array(found[0]), np.array(found[1])


async def board_opened(here: Stack, key: str, times: int) -> tuple[np.ndarray, np.ndarray]:
    """Click the board in the list of boards; ms from the click, and from the first data, on."""
    clicked, data = [], []
    async with pages.browser_page(NOTE_BOARD, height=HEIGHT) as page:
        await pages.sign_in(page, here, "/boards")
        for _ in range(times):
            link = page.locator(f"a[href^='/boards/{key}']").first
            await link.wait_for()
            await asyncio.sleep(1)
            await page.evaluate(f"window.__board.all = {COUNTS['chart']}")
            await link.click()
            await pages.until_true(page, "window.__board.drawn > 0")
            note = await page.evaluate(
                "(({ clicked, dataAt, drawn }) => [clicked, dataAt, drawn])(window.__board)"
            )
            clicked.append(note[2] - note[0])
            data.append(note[2] - note[1])
            await page.go_back()
    return np.array(clicked), np.array(data)


async def fleet_opened(here: Stack, path: str, ready: str, seconds: float) -> Opened:
    """Open a page of all sites, and scroll through it."""
    async with pages.browser_page(NOTE_FRAMES) as page:
        await pages.sign_in(page, here, path)
        await page.locator(ready).first.wait_for()
        # Twice: the first look fetches what the browser then has.
        await page.reload()
        await page.locator(ready).first.wait_for()
        listed = await page.evaluate("performance.now()")
        paint = await page.evaluate(
            "performance.getEntriesByName('first-contentful-paint')[0].startTime"
        )
        await asyncio.sleep(2)
        await page.mouse.move(700, 500)
        await page.evaluate("window.__frames = []")
        await _scroll(page, seconds)
        return Opened(paint, listed, np.array(await page.evaluate("window.__frames")))


async def _scroll(page: Page, seconds: float) -> None:
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        await page.mouse.wheel(0, 600)
        await asyncio.sleep(0.05)
