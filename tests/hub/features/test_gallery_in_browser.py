"""Each tile of boards, in each of its states, as the gallery shows it in a real Chromium.

On every change each tile is looked at on one screen, and all screens come up in turn. As the proof
``tiles`` (`make proofs ONLY=tiles`) each is looked at on all of them, and the table is written.
``TALAIA_PICTURES=folder`` keeps a picture of each.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest
from page_accessibility import find_violations
from playwright.async_api import expect

from ..chromium import program_or_skip

pytestmark = [pytest.mark.browser, pytest.mark.timeout(1500)]
ROOT = Path(__file__).parents[3]
# What is wider than its tile; what scrolls sideways on purpose has a place of its own inside.
CLIPPED = """gallery => [...gallery.renderRoot.querySelectorAll('figure')].flatMap(figure => {
    const inside = figure.querySelector('t-board-tile').renderRoot.querySelector('.inside');
    return inside.scrollWidth > inside.clientWidth + 1
      ? [`${figure.querySelector('figcaption').textContent}: wider than its tile`] : [];
  })"""
WIDTH = "document.documentElement.scrollWidth"
WIDTHS = (390, 820, 1440, 2560)
THEMES = ("light", "dark", "night")
# So that neighbours differ in both.
SCREENS = tuple((WIDTHS[at % 4], THEMES[at % 3]) for at in range(12))
CATALOGUE = ROOT / "web" / "src" / "tiles" / "board" / "board-catalog.ts"


async def look(page, tile: str, width: int, theme: str) -> list[str]:
    """Say what is wrong with a tile on a screen, in all of its states."""
    await page.set_viewport_size({"width": width, "height": 900})
    await page.evaluate("theme => { document.documentElement.dataset.theme = theme }", theme)
    await expect(page.locator("t-page-gallery t-board-tile").first).to_be_visible()
    await expect(page.locator("t-page-gallery t-loading")).to_have_count(0)
    if folder := os.environ.get("TALAIA_PICTURES"):
        path = Path(folder) / f"tile-{tile}-{width}-{theme}.png"
        await page.screenshot(path=path, full_page=True)
    gallery = page.locator("t-page-gallery")
    found = [*await find_violations(page), *await gallery.evaluate(CLIPPED)]
    if (wide := await page.evaluate(WIDTH)) > width:
        found.append(f"the page is {wide} px wide")
    return [f"{tile} at {width} px, {theme}: {each}" for each in found]


def write_table(path: Path, states: dict[str, int]) -> None:
    """Write down what was looked at; nothing was found, or there is no table."""
    rows = "".join(f"| {tile} | {many} | 0 |\n" for tile, many in states.items())
    path.write_text(
        "# Tiles of boards\n\n"
        "Written by `make proofs ONLY=tiles`. Each tile of the gallery in each of its states, at"
        f" {', '.join(map(str, WIDTHS))} px, in the themes {', '.join(THEMES)}, in Chromium:"
        " violations of axe's rules, and what is wider than its tile or its page.\n\n"
        f"| tile | states | found on {len(SCREENS)} screens |\n|---|--:|--:|\n{rows}"
    )


async def test_each_tile_in_each_state_keeps_the_rules_of_axe_and_fits(hub, chromium) -> None:
    program_or_skip()
    # The gallery is made up in the page itself: nobody has to be signed in, and no robot is there.
    page = await chromium.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    tiles = re.findall(r'^    type: "(\w+)"', CATALOGUE.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(tiles) > 20
    table = os.environ.get("TALAIA_PROOF_TABLE", "")
    found, states = [], {}
    for at, tile in enumerate(tiles):
        await page.goto(f"{hub.origin}/gallery?tile={tile}")
        for width, theme in SCREENS if table else (SCREENS[at % len(SCREENS)],):
            found += await look(page, tile, width, theme)
        states[tile] = await page.locator("t-page-gallery figure").count()
        # Words of one's own are open to whoever sees the board, and read nothing of the hub.
        assert states[tile] >= (2 if tile == "text" else 7), tile
    assert found == []
    assert errors == []
    if table:
        write_table(Path(table), states)
