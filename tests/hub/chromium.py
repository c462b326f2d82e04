"""A real Chromium, and a person who signs in with it."""

from __future__ import annotations

import asyncio
import os

import pytest
import pytest_asyncio
from browser_program import FLAGS, SPACE_FLAGS, find_browser
from patience import PATIENCE_MS

from talaia.web import static_dir

PASSWORD = "a password for tests"  # noqa: S105


def program_or_skip(*names: str) -> str:
    """Name Chromium's program; without it, or without the built pages, there is no test.

    With ``names`` it is one of these programs; see `browser_program`.
    """
    program = find_browser(names) if names else find_browser()
    missing = "" if program else "Chromium"
    missing = missing or ("" if (static_dir() / "index.html").is_file() else "the built pages")
    if missing:
        (pytest.fail if os.environ.get("TALAIA_REQUIRE_ALL") else pytest.skip)(f"no {missing}")
    return program or ""


@pytest_asyncio.fixture(scope="session", loop_scope="session")
async def _browser():
    """One Chromium for all tests of a process: with what drives it, a start computes a second."""
    program = program_or_skip()
    clean = {key: value for key, value in os.environ.items() if key != "LD_LIBRARY_PATH"}
    # Most tests need no browser, and no program that drives one.
    from playwright.async_api import async_playwright, expect

    # Beside other work a page takes its time to open.
    expect.set_options(timeout=PATIENCE_MS)
    async with async_playwright() as play:
        running = await play.chromium.launch(executable_path=program, args=FLAGS, env=clean)
        yield running
        await running.close()


@pytest.fixture
def _function_scoped_runner(request):
    """Run a test with a browser in the loop of that browser, and each other test in its own.

    The name is pytest-asyncio's: by it all fixtures of one test follow.
    """
    if "chromium" not in request.fixturenames:
        yield request.getfixturevalue("_function_scoped_runner")
        return
    runner = request.getfixturevalue("_session_scoped_runner")
    request.getfixturevalue("_browser")
    before = asyncio.all_tasks(runner.get_loop())
    yield runner
    # As at the end of a loop: what a test has left running meets no other test.
    runner.run(_end_tasks(asyncio.all_tasks(runner.get_loop()) - before))


async def _end_tasks(tasks: set[asyncio.Task]) -> None:
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


@pytest.fixture
async def chromium(_browser):
    """The browser, with nothing open in it; what a test opens is closed behind it."""
    yield _browser
    for context in _browser.contexts:
        await context.close()


@pytest.fixture
async def space():
    """Give a Chromium that draws in space by software."""
    program = program_or_skip()
    from playwright.async_api import async_playwright

    async with async_playwright() as play:
        running = await play.chromium.launch(executable_path=program, args=SPACE_FLAGS)
        yield running
        await running.close()


async def sign_in(
    chromium,
    hub,
    name: str,
    password: str = PASSWORD,
    *,
    script: str = "",
    to: str = "/home",
    workers: str = "block",
):
    """Open a page, ``to``, whose errors are kept in ``page.errors``.

    ``script`` runs in it before anything else. Each page that is opened computes half of a second,
    without the service worker, which fetches the pages' files once more (``workers="allow"``).
    """
    page = await chromium.new_page(viewport={"width": 1440, "height": 900}, service_workers=workers)
    page.set_default_timeout(PATIENCE_MS)
    if script:
        await page.add_init_script(script)
    await sign_in_on(page, hub, name, password, to=to)
    return page


async def sign_in_on(page, hub, name: str, password: str = PASSWORD, *, to: str = "/home") -> None:
    """Sign in on a page that is there; what goes wrong in it is kept in ``errors``.

    As the form does, without the form: its page costs a browser as much as the next.
    """
    page.errors = []
    page.on("pageerror", lambda error: page.errors.append(str(error)))
    answer = await page.context.request.post(
        f"{hub.origin}/api/login",
        data={"name": name, "password": password},
        headers={"Origin": hub.origin},
    )
    assert answer.ok, await answer.text()
    await page.goto(f"{hub.origin}{to}")
    if to == "/home":
        await page.wait_for_url(lambda url: url.endswith(("/home", "/public")))
