"""Pages in a language that nobody speaks: nothing stays English or is wider than its page.

On every change some pages are looked at, as an admin sees them and as a guest does, at a desk and
on a phone. As the proof ``words`` (`make proofs ONLY=words`) all of them are, and the table is
written. ``TALAIA_PICTURES=folder`` keeps a picture of each.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest
import yaml
from playwright.async_api import expect

from ..chromium import PASSWORD, program_or_skip
from ..pseudo_language import ACCENTS, SAID, WIDTH, english_of, speak_pseudo, words_of

pytestmark = [pytest.mark.browser, pytest.mark.timeout(900)]
ROOT = Path(__file__).parents[3]
SITE = "observatory"
EXAMPLE = ROOT / "examples" / "observatory" / "site.yaml"
# What the description's own author wrote for people to read.
AUTHORS = frozenset({"name", "description", "note", "advice", "about"})
WIDTHS = (1440, 390)
FEW = ("/home", "/devices", "/alarms", "/account", "/admin/people", "SITE/history", "SITE/night")
OF_HUB = (
    *("/home", "/map", "/fleet", "/devices", "/boards", "/alarms", "/account", "/public"),
    *(f"/admin/{page}" for page in ("people", "roles", "gateways", "clients", "ways", "storage")),
    *("/admin/description", "/admin/audit", "/admin/support", "/nowhere", "/logout"),
)
OF_SITE = (
    *("live", "drive", "scene", "topics", "history", "logbook", "log", "notes", "anomalies"),
    *("cause", "missions", "recordings", "cameras", "sightings", "review", "night", "forecast"),
    *("requests", "requests?new=1", "proposals", "alertrules", "archive"),
    *(f"devices/{device}" for device in ("dome", "telescope", "weather", "camera", "power")),
)
WHOLE = (*OF_HUB, *(f"SITE/{page}" for page in OF_SITE))
OF_GUESTS = ("/public", "/account", "SITE/live", "/nowhere")


def foreign(value: object) -> object:
    """Write a description's names with accents, as if somebody had translated it."""
    if isinstance(value, dict):
        return {
            key: inside.translate(ACCENTS)
            if key in AUTHORS and isinstance(inside, str)
            else foreign(inside)
            for key, inside in value.items()
        }
    return [foreign(inside) for inside in value] if isinstance(value, list) else value


def own_words(value: object) -> set[str]:
    """Give the words of a description that its robot says: states, identifiers, addresses."""
    if isinstance(value, dict):
        return set().union(*(own_words(part) for pair in value.items() for part in pair), set())
    if isinstance(value, list):
        return set().union(*(own_words(part) for part in value), set())
    return set(words_of(value.replace("_", " "))) if isinstance(value, str) else set()


async def look(page, path: str, data: set[str]) -> list[str]:
    """Say what is English on a page, and how much wider it is than its window."""
    found = []
    for width in WIDTHS:
        await page.set_viewport_size({"width": width, "height": 844})
        await expect(page.locator("main > *").first).to_be_visible()
        await expect(page.locator("t-loading")).to_have_count(0)
        if folder := os.environ.get("TALAIA_PICTURES"):
            name = path.strip("/").replace("/", "-").replace("?", "-")
            await page.screenshot(path=Path(folder) / f"pseudo-{name}-{width}.png")
        found += [f"{path}: “{text}”" for text in english_of(await page.evaluate(SAID), data)]
        if (wide := await page.evaluate(WIDTH)) > width:
            found.append(f"{path} is {wide} px wide at {width} px")
    return list(dict.fromkeys(found))


async def open_as(chromium, hub, name: str):
    """Open a browser of somebody who reads that language; its first page is a missing one."""
    context = await chromium.new_context(service_workers="block")
    await speak_pseudo(context)
    page = await context.new_page()
    page.errors = []
    page.on("pageerror", lambda error: page.errors.append(str(error)))
    login = {"name": name, "password": PASSWORD}
    answer = await context.request.post(
        f"{hub.origin}/api/login", data=login, headers={"Origin": hub.origin}
    )
    assert answer.ok, await answer.text()
    return page


def write_table(path: Path, looked: dict[str, int]) -> None:
    """Write down what was looked at; nothing was found, or there is no table."""
    rows = "".join(f"| {who} | {many} | 0 |\n" for who, many in looked.items())
    path.write_text(
        "# Words of the pages\n\n"
        "Written by `make proofs ONLY=words`. Each page in a language that nobody speaks, whose"
        " texts are 30 % longer than the English ones, in Chromium at"
        f" {' and '.join(map(str, WIDTHS))} px: texts that stayed English, and pages wider than"
        " their window.\n\n"
        f"| seen by | pages | found |\n|---|--:|--:|\n{rows}"
    )


async def test_no_page_says_anything_that_no_catalogue_has_or_is_wider_than_its_window(
    hub, chromium
) -> None:
    program_or_skip()
    described = yaml.safe_load(EXAMPLE.read_text(encoding="utf-8"))
    key = await hub.hub.gateways.registry.new_key(SITE)
    dome = await hub.gateway(key=key)
    await dome.hello(yaml.safe_dump(foreign(described), allow_unicode=True), site=SITE)
    table = os.environ.get("TALAIA_PROOF_TABLE", "")
    visits = {"admin": WHOLE if table else FEW, "guest": OF_GUESTS if table else OF_GUESTS[:1]}
    data = own_words(described)
    found = []
    for name, paths in visits.items():
        page = await open_as(chromium, hub, name)
        for path in paths:
            await page.goto(hub.origin + path.replace("SITE", f"/sites/{SITE}"))
            found += await look(page, path, data)
        found += [f"{name}: {error}" for error in page.errors]
    assert found == [], "\n".join(found)
    if table:
        write_table(Path(table), {name: len(paths) for name, paths in visits.items()})
