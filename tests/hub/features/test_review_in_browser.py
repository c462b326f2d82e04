"""A day of sightings looked through in a real Chromium, with keys and with a clip that plays."""

from __future__ import annotations

import hashlib
import os
import re
from pathlib import Path
from zlib import crc32

import av
import numpy as np
import pytest
import simplejpeg
from page_accessibility import find_violations
from playwright.async_api import expect

from talaia.model.detection import Detect, PictureZone
from talaia.wire import frames
from talaia.wire.browser import SightingUpdate
from talaia.wire.frames import FILES_FROM_GATEWAY, FILES_FROM_HUB, FilePiece, FilmOffer

from ..chromium import sign_in
from ..seeing import seeing
from .test_pages_in_browser import WIDTH

pytestmark = [pytest.mark.browser, pytest.mark.timeout(400)]

FRONT = "camera/front"
MAT = PictureZone(name="Mat", points=((0.1, 0.5), (0.6, 0.5), (0.6, 1.0)))
SEEING = seeing(Detect(zones={"mat": MAT}))
# 13:00 by the site's clock.
NOON = 1_700_049_600_000_000
MINUTE = 60_000_000


def picture(shade: int) -> bytes:
    pixels = np.full((120, 160, 3), 40, np.uint8)
    pixels[20:110, 40 : 40 + shade % 80] = (shade % 255, 140, 200)
    return simplejpeg.encode_jpeg(pixels, 85)


def make_film(path: Path) -> bytes:
    """Write a film of eight seconds, of a bar that goes to the right."""
    with av.open(str(path), "w", format="mp4") as film:
        stream = film.add_stream("h264", rate=10)
        stream.width, stream.height, stream.pix_fmt = 320, 240, "yuv420p"
        for at in range(80):
            pixels = np.full((240, 320, 3), 30, np.uint8)
            pixels[60:200, 3 * at : 3 * at + 40] = (220, 180, 90)
            shot = av.VideoFrame.from_ndarray(pixels, format="rgb24")
            film.mux(stream.encode(shot))
        film.mux(stream.encode())
    return path.read_bytes()


async def bring_film(hub, body: bytes, begin_us: int) -> None:
    """Hand a film to the hub as its gateway does."""
    line = await hub.dial("/gateway/files", {"Authorization": f"Bearer {hub.keys['agv']}"})
    name = "20231115T115955Z-f00001"
    offer = FilmOffer(
        id=name, stream=FRONT, size=len(body), digest=hashlib.sha256(body).hexdigest(),
        why="person in sight", begin_us=begin_us, end_us=begin_us + 8_000_000, pictures=80,
    )  # fmt: skip
    await line.send(FILES_FROM_GATEWAY.encode(offer))
    has = FILES_FROM_HUB.decode(await line.recv())
    while not has.done:
        data = body[has.have : has.have + 60_000]
        await line.send(
            FILES_FROM_GATEWAY.encode(FilePiece(id=name, at=has.have, check=crc32(data), data=data))
        )
        has = FILES_FROM_HUB.decode(await line.recv())
        assert not has.refused


async def keep(page, name: str) -> None:
    """Keep screenshots of desktop and phone, light and dark, where a person asked for them."""
    folder = os.environ.get("TALAIA_PICTURES")
    if not folder:
        return
    for width in (1440, 390):
        await page.set_viewport_size({"width": width, "height": 900})
        for scheme in ("light", "dark"):
            await page.emulate_media(color_scheme=scheme)
            await page.screenshot(path=Path(folder) / f"{name}-{width}-{scheme}.png")
    await page.set_viewport_size({"width": 1440, "height": 900})
    await page.emulate_media(color_scheme="light")


async def test_a_day_is_looked_through_by_keys_and_what_was_seen_stays_seen(
    hub, chromium, tmp_path
):
    gateway = await hub.gateway()
    await gateway.hello(SEEING)
    told = await hub.page("operator")
    stay = frames.ZoneStay(zone="Mat", entries=1, dwell_s=12.0)
    for at in range(6):
        began = NOON + at * MINUTE - (2 * 1440 * MINUTE if at == 0 else 0)
        await gateway.say(
            frames.SightingReport(
                stream=FRONT, label="dog" if at == 3 else "person", many=1, confidence=0.8,
                began_us=began, ended_us=began + 20_000_000, thumbnail=picture(30 * at + 40),
                stays=[stay] if at == 4 else [],
            )
        )  # fmt: skip
    await told.hear(SightingUpdate, lambda news: news.began_us == NOON + 5 * MINUTE)
    await bring_film(hub, make_film(tmp_path / "film.mp4"), NOON + 5 * MINUTE - 3_000_000)

    page = await sign_in(chromium, hub, "operator", to="/sites/agv/review")
    days = page.get_by_role("navigation", name="Days")
    await expect(days.get_by_role("link")).to_have_count(2)
    await expect(days.get_by_role("link").first).to_contain_text("5 new of 5")
    rows = page.locator("li[data-sighting]")
    await expect(rows).to_have_count(5)
    stage = page.get_by_label("Shown now")
    await expect(stage).to_contain_text("13:05:00")
    # The film that was made around it, from before it came into sight.
    video = page.locator("t-sighting-clip video")
    await expect(video).to_be_visible()
    await page.wait_for_function(
        """() => {
          const find = (root) => [...root.querySelectorAll('*')].flatMap((one) =>
            one.localName === 'video' ? [one] : one.shadowRoot ? find(one.shadowRoot) : []);
          return find(document)[0]?.readyState >= 2;
        }"""
    )
    await page.keyboard.press("Space")
    playing = """video => new Promise((done) => {
      video.addEventListener("timeupdate", () => video.currentTime > 0.3 && done(true));
    })"""
    assert await video.evaluate(playing)
    await page.keyboard.press("Space")
    assert await video.evaluate("video => video.paused")
    assert await find_violations(page) == []
    await page.set_viewport_size({"width": 390, "height": 900})
    assert await page.evaluate(WIDTH) <= 390
    await page.set_viewport_size({"width": 1440, "height": 900})
    await keep(page, "review")

    await page.keyboard.press("j")
    await expect(stage).to_contain_text("13:04:00")
    await expect(stage).to_contain_text("12 s in Mat")
    await page.keyboard.press("k")
    await page.keyboard.press("s")
    # On to the next one; the mark is the person's own, and stays.
    await expect(stage).to_contain_text("13:04:00")
    await expect(rows.first).to_contain_text("seen")
    await expect(days.get_by_role("link").first).to_contain_text("4 new of 5")
    await page.reload()
    await expect(rows).to_have_count(4)
    await page.get_by_label("Also what I have seen").check()
    await expect(rows).to_have_count(5)

    await page.get_by_label("Zone or line").select_option("Mat")
    await expect(rows).to_have_count(1)
    await page.get_by_label("Zone or line").select_option("")
    await page.get_by_label("Object").select_option("dog")
    await expect(rows).to_have_count(1)
    await page.get_by_label("Object").select_option("")
    await page.get_by_label("Also what I have seen").uncheck()
    await expect(rows).to_have_count(4)
    await page.get_by_role("button", name="All of these seen").click()
    await expect(days.get_by_role("link").first).to_contain_text("all 5 seen")
    # Of another day there is something left.
    await page.reload()
    await expect(rows).to_have_count(1)
    await days.get_by_role("link", name=re.compile("all 5 seen")).click()
    await expect(page.get_by_text("You have seen everything")).to_be_visible()
    await keep(page, "review-done")
    assert page.errors == []


async def test_who_may_not_see_the_camera_has_nothing_to_look_through(hub, chromium):
    gateway = await hub.gateway()
    await gateway.hello(SEEING)
    told = await hub.page("operator")
    await gateway.say(
        frames.SightingReport(
            stream=FRONT, label="person", many=1, confidence=0.8,
            began_us=NOON, ended_us=NOON + MINUTE,
        )
    )  # fmt: skip
    await told.hear(SightingUpdate)
    page = await sign_in(chromium, hub, "guest", to="/sites/agv/review")
    await expect(page.get_by_text("Nothing seen yet")).to_be_visible()
    await expect(page.locator("li[data-sighting]")).to_have_count(0)
    await keep(page, "review-empty")
    assert page.errors == []
