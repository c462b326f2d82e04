"""Web components of the administrator's folder: served safely, and shown in a real Chromium."""

from __future__ import annotations

import dataclasses
import json
import shutil
from pathlib import Path

import pytest
from msgspec.structs import replace
from playwright.async_api import expect

from talaia.clock import SystemClock
from talaia.hub.errors import CannotStart
from talaia.hub.features.extensions import tiles_of
from talaia.hub.settings import Settings
from talaia.model.yaml_text.load import dump_site, read_site

from ..chromium import sign_in

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]
ROOT = Path(__file__).parents[3]
EXAMPLE = read_site(ROOT / "examples" / "observatory" / "site.yaml")
TILES = ROOT / "examples" / "extensions" / "tiles"
BROKEN = {
    "throws": "export default class extends HTMLElement { update() { throw Error('it fell'); } }",
    "unparsed": "export default class {{{",
    "html": "<html>export</html>",
}


@pytest.fixture
def extensions(tmp_path_factory):
    folder = tmp_path_factory.mktemp("extensions") / "tiles"
    shutil.copytree(TILES, folder)
    manifest = (TILES / "wind_gauge" / "tile.json").read_text()
    for name, module in BROKEN.items():
        (folder / name).mkdir()
        (folder / name / "tile.json").write_text(
            json.dumps({**json.loads(manifest), "title": name})
        )
        (folder / name / "tile.js").write_text(module)
    return folder


@pytest.fixture
def settings(settings, extensions):
    return dataclasses.replace(settings, extensions=extensions)


async def test_a_tile_shows_a_live_value_and_broken_ones_take_nothing_with_them(
    chromium, hub
) -> None:
    site = replace(EXAMPLE, site="agv", interlocks={}, enclosures={}, alarms={}, night=None)
    gateway = await hub.gateway()
    await gateway.hello(description=dump_site(site))
    page = await sign_in(chromium, hub, "admin", to="/sites/agv/devices/weather")
    await expect(page.locator("t-extension-tile")).to_have_count(3)
    gateway.channels = {channel.address: at for at, channel in enumerate(site.channels())}
    await gateway.samples(("weather/wind", SystemClock().wall_ns() // 1000, 23.0))
    await expect(page.locator("talaia-tile-wind_gauge output")).to_have_text("23 km/h")
    alerts = page.get_by_role("alert")
    await expect(alerts.filter(has_text="“throws”")).to_contain_text("it fell")
    await expect(alerts.filter(has_text="“unparsed”")).to_contain_text("SyntaxError")
    await expect(alerts.filter(has_text="“html”")).to_contain_text("is not JavaScript")
    await expect(page.get_by_role("heading", name="Values")).to_be_visible()
    assert page.errors == []


async def test_files_are_given_to_who_is_signed_in_and_none_outside_the_folder(hub) -> None:
    client = await hub.client("guest")
    answer = await client.get("/extensions/wind_gauge/tile.js")
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith("text/javascript")
    assert "default-src 'self'" in answer.headers["content-security-policy"]
    for path in (
        "wind_gauge/../../secret.js",
        "wind_gauge/%2e%2e/html/tile.js",
        "html/tile.js",
        "wind_gauge/..%2f..%2fetc%2fpasswd",
        "wind_gauge/%00",
        "other/tile.js",
    ):
        assert "export" not in (await client.get(f"/extensions/{path}")).text
    assert (await client.post("/extensions/wind_gauge/tile.js")).status_code in {403, 405}
    assert (await client.get("/api/tiles")).json()["broken"] == []
    stranger = await hub.client()
    assert (await stranger.get("/extensions/wind_gauge/tile.js")).status_code == 401


def test_a_folder_that_is_missing_or_in_the_data_folder_is_refused_at_the_start(tmp_path) -> None:
    for chosen in (tmp_path / "nowhere", tmp_path / "data" / "tiles"):
        with pytest.raises(CannotStart, match="--extensions"):
            tiles_of(Settings(data=tmp_path / "data", extensions=chosen))
