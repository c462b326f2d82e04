"""The pages' service worker in a real Chromium: an update, a hub that is away, and what is kept."""

from __future__ import annotations

import asyncio
import shutil
import socket
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
import uvicorn
from fastapi import FastAPI
from page_accessibility import find_violations
from playwright.async_api import expect

from talaia.hub.api.guarded_routes import add_guarded, set_guards
from talaia.hub.api.static_pages import Pages
from talaia.web import static_dir

from ..chromium import sign_in

pytestmark = [pytest.mark.browser, pytest.mark.timeout(180)]
ROOT = Path(__file__).parents[3]
WIDTH = "document.documentElement.scrollWidth"
# A browser registers it once the page has time; a page is its own from then on.
CONTROLLED = """async () => { await navigator.serviceWorker.ready;
  while (!navigator.serviceWorker.controller)
    await new Promise(resolve => navigator.serviceWorker.addEventListener(
      'controllerchange', resolve, {once: true})); }"""
KEPT = """async () => (await Promise.all((await caches.keys()).map(async name =>
  (await (await caches.open(name)).keys()).map(({url}) => new URL(url).pathname)))).flat()"""
UPDATE = "async () => { await (await navigator.serviceWorker.ready).update(); }"
HEADING = "No connection to the hub"


@asynccontextmanager
async def serving(folder: Path, port: int):
    """Serve pages of a folder, as a hub does, and nothing else."""
    app = FastAPI()
    set_guards(app)
    add_guarded(app, Pages(folder).make_router())
    config = uvicorn.Config(app, log_level="error", lifespan="off", timeout_graceful_shutdown=1)
    server = uvicorn.Server(config)
    # Before it returns it listens: no request comes too early.
    listener = socket.create_server(("127.0.0.1", port))
    task = asyncio.create_task(server.serve(sockets=[listener]))
    try:
        yield
    finally:
        server.should_exit = True
        await task


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def publish_version(folder: Path, version: str) -> None:
    """Give the worker another version, as another build of the pages does."""
    text = (static_dir() / "worker.js").read_text()
    prefix = "talaia-shell-"
    assert prefix in text
    (folder / "worker.js").write_text(f"{text}\n// {version}\n".replace(prefix, prefix + version))
    (folder / "worker.js.gz").unlink(missing_ok=True)


async def test_pages_open_without_a_hub_as_one_that_says_so_and_come_back_by_themselves(
    chromium, tmp_path
) -> None:
    folder, port = tmp_path / "static", free_port()
    shutil.copytree(static_dir(), folder)
    origin = f"http://127.0.0.1:{port}"
    page = await chromium.new_page(viewport={"width": 390, "height": 844})
    async with serving(folder, port):
        await page.goto(f"{origin}/login")
        await page.evaluate(CONTROLLED)
    await page.goto(f"{origin}/sites/agv/live")
    await expect(page.get_by_role("heading", name=HEADING)).to_be_visible()
    await expect(page.get_by_text("STOP cannot be pressed from here")).to_be_visible()
    await assert_axe_finds_nothing_in_any_theme(page)
    async with serving(folder, port):
        # Nobody touches anything.
        await expect(page.locator("t-app")).to_be_attached()
        assert page.url == f"{origin}/sites/agv/live"


async def assert_axe_finds_nothing_in_any_theme(page) -> None:
    for theme, width in (("light", 390), ("dark", 820), ("night", 1440), ("light", 2560)):
        await page.set_viewport_size({"width": width, "height": 844})
        await page.evaluate("theme => { document.documentElement.dataset.theme = theme }", theme)
        assert await find_violations(page) == [], theme
        assert await page.evaluate(WIDTH) <= width


async def test_another_version_takes_over_at_once_and_keeps_only_the_one_before(
    chromium, tmp_path
) -> None:
    folder, port = tmp_path / "static", free_port()
    shutil.copytree(static_dir(), folder)
    publish_version(folder, "a")
    page = await chromium.new_page()
    async with serving(folder, port):
        await page.goto(f"http://127.0.0.1:{port}/login")
        await page.evaluate(CONTROLLED)
        for version, kept in (("b", ["a", "b"]), ("c", ["b", "c"])):
            publish_version(folder, version)
            await page.evaluate(UPDATE)
            await page.wait_for_function(
                "async (kept) => (await caches.keys()).map(name => name.slice(13, 14)).join()"
                " === kept",
                arg=",".join(kept),
            )
        # A file that is no more is not given out of the former shell as if it were there.
        answer = await page.evaluate("fetch('/assets/none-1234.js').then(({status}) => status)")
        assert answer == 404


async def test_nothing_that_a_sign_in_is_needed_for_is_kept(hub, chromium) -> None:
    gateway = await hub.gateway()
    await gateway.hello()
    page = await sign_in(chromium, hub, "admin", workers="allow")
    await page.evaluate(CONTROLLED)
    await page.goto(f"{hub.origin}/sites/agv/live")
    await expect(page.get_by_role("heading", name="Speed")).to_be_visible()
    kept = await page.evaluate(KEPT)
    plain = {"/offline.html", "/offline.css", "/offline.js", "/icon.svg"}
    assert plain < set(kept)
    assert [path for path in kept if path not in plain and not path.startswith("/assets/")] == []
    # It is installable: what a manifest names is there.
    manifest = await (await page.request.get(f"{hub.origin}/manifest.webmanifest")).json()
    for icon in manifest["icons"]:
        assert (await page.request.get(hub.origin + icon["src"])).ok
    assert page.errors == []
