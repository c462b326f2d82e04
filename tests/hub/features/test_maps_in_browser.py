"""Maps and the fleet in a real Chromium: a file's tiles, zones, robots, and a thousand sites."""

from __future__ import annotations

import dataclasses
import io
import json
import struct
import time

import pytest
from page_accessibility import find_violations
from PIL import Image
from playwright.async_api import expect

from ..chromium import sign_in
from .test_maps import MAPPED, NOW

pytestmark = [pytest.mark.browser, pytest.mark.timeout(600)]
# In no theme of ours.
TILE = (200, 30, 180)


def pmtiles(picture: bytes) -> bytes:
    """A file of one picture for the whole world, by the specification of PMTiles, version 3."""
    # One entry: tile 0, once, so long, at the beginning (1 more is written).
    directory = bytes([1, 0, 1]) + varint(len(picture)) + bytes([1])
    about = b'{"attribution": "<b>Test</b> makers"}'
    at = 127
    spans = [(at, len(directory)), (at + len(directory), len(about))]
    leaves = at + len(directory) + len(about)
    spans += [(leaves, 0), (leaves, len(picture))]
    head = b"PMTiles\x03" + b"".join(struct.pack("<QQ", *span) for span in spans)
    head += struct.pack("<QQQ", 1, 1, 1)
    # Clustered, nothing compressed, PNG, zoom 0 to 0; bounds and middle.
    head += bytes([1, 1, 1, 2, 0, 0])
    east, north = 1_800_000_000, 850_000_000
    head += struct.pack("<iiiiBii", -east, -north, east, north, 0, 0, 0)
    return head + directory + about + picture


def varint(number: int) -> bytes:
    out = b""
    while number > 127:
        out += bytes([number & 127 | 128])
        number >>= 7
    return out + bytes([number])


@pytest.fixture
def settings(settings, tmp_path):
    folder = tmp_path / "maps"
    folder.mkdir()
    picture = io.BytesIO()
    Image.new("RGB", (256, 256), TILE).save(picture, "PNG")
    (folder / "yard.pmtiles").write_bytes(pmtiles(picture.getvalue()))
    return dataclasses.replace(settings, maps=folder)


async def has_tile_colour(page) -> bool:
    shot = Image.open(io.BytesIO(await page.locator("t-geo-map").screenshot())).convert("RGB")
    return {c: n for n, c in shot.getcolors(1 << 24) or []}.get(TILE, 0) > 1000


async def until_tiles(page, *, drawn: bool) -> None:
    """Look again until the file's tiles are drawn, or until none is any more."""
    deadline = time.monotonic() + 60
    while await has_tile_colour(page) is not drawn:
        assert time.monotonic() < deadline, "the tiles are " + ("missing" if drawn else "there")


async def test_a_fleet_stands_on_a_map_whose_ground_a_person_chooses(
    chromium, hub, history
) -> None:
    gateway = await hub.gateway()
    await gateway.hello(MAPPED)
    rows = [("base/pose.x", NOW, 100.0), ("base/pose.y", NOW, 0.0), ("base/pose.yaw", NOW, 0.0)]
    await gateway.samples(*rows)
    await history.appended.wait()
    page = await sign_in(chromium, hub, "admin")
    await page.get_by_role("link", name="Map of all robots").click()
    ground = page.get_by_label("Map under the robots")
    await expect(ground).to_have_value("file yard")
    await expect(page.get_by_text("Test makers")).to_be_visible()
    await expect(page.get_by_role("img", name="and 1 zone")).to_be_visible()
    await until_tiles(page, drawn=True)
    # Without the file there is the coarse world; the choice stays.
    await ground.select_option("world")
    await expect(page.get_by_text("Test makers")).to_be_hidden()
    await until_tiles(page, drawn=False)
    await page.reload()
    await expect(ground).to_have_value("world")

    # A server of others: said what it is told, and refused until that is allowed.
    await page.get_by_role("button", name="Allow a tile server").click()
    form = page.locator("t-map-sources form")
    await form.get_by_label("Name").fill("Streets")
    await form.get_by_label("Address").fill("https://tiles.example.org/{z}/{x}/{y}.png")
    await form.get_by_role("button", name="Allow it").click()
    await expect(page.get_by_text("Say first that you allow")).to_be_visible()
    await form.get_by_label("I allow that").check()
    await form.get_by_role("button", name="Allow it").click()
    await expect(page.get_by_text("asks tiles.example.org", exact=True)).to_be_visible()
    assert await find_violations(page) == []
    for size in ((390, 844), (1440, 900)):
        await page.set_viewport_size({"width": size[0], "height": size[1]})
        assert await page.evaluate("document.documentElement.scrollWidth") <= size[0]
    # The robot is where it stands: a click in the middle of the map opens its site. It says so
    # once more: on a slow machine what it said first may be old by now.
    await gateway.samples(*((address, time_us + 1, value) for address, time_us, value in rows))
    await page.goto(f"{hub.origin}/map?site=agv")
    await expect(page.get_by_text("41.38700° N, 2.16920° E")).to_be_visible()
    box = await page.locator("t-geo-map").bounding_box()
    await page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    await page.wait_for_url("**/sites/agv/live")
    assert page.errors == []


def sites_of(row: dict[str, object], count: int) -> list[dict[str, object]]:
    return [
        {
            **row,
            "site": f"robot{n}",
            "name": f"Robot {n}",
            "group": f"Hall {n % 7}",
            "tags": ["indoor"] if n % 2 else ["yard"],
            "battery": n % 101,
        }
        for n in range(count)
    ]


async def test_a_thousand_sites_are_there_and_found_by_a_word(chromium, hub, gateway) -> None:
    operator = await hub.client("operator")
    row = (await operator.get("/api/sites")).json()[0]
    body = json.dumps(sites_of(row, 1000))
    page = await sign_in(chromium, hub, "operator")

    async def many(route) -> None:
        await route.fulfill(body=body, content_type="application/json")

    await page.route("**/api/sites", many)
    await page.goto(f"{hub.origin}/home")
    await expect(page.get_by_role("link", name="Robot 0", exact=True)).to_be_visible()
    await expect(page.get_by_text("1000 of 1000 online")).to_be_visible()
    assert await page.locator("t-fleet-card").count() < 200
    await page.get_by_label("Search sites").fill("robot 993 yard")
    await expect(page.get_by_text("No site fits")).to_be_visible()
    await page.get_by_label("Search sites").fill("robot 993 indoor")
    await expect(page.get_by_role("link", name="Robot 993", exact=True)).to_be_visible()
    await expect(page.locator("t-fleet-card")).to_have_count(1)
    await page.get_by_label("Search sites").fill("")
    await page.get_by_label("Order").select_option("battery")
    await expect(page.get_by_text("battery 0 %").first).to_be_visible()
    assert await find_violations(page) == []
    await page.set_viewport_size({"width": 390, "height": 844})
    assert await page.evaluate("document.documentElement.scrollWidth") <= 390
    assert page.errors == []
