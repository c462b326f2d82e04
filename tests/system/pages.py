"""Pages in a real Chromium: a person signed in, and pictures of what is on the screen."""

from __future__ import annotations

import os
import re
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Protocol

from patience import PATIENCE_MS, PATIENCE_S
from playwright.sync_api import Browser, Page

from .stack import PASSWORD


class Served(Protocol):
    """A hub somewhere."""

    @property
    def address(self) -> str: ...


def sign_in(page: Page, hub: Served, name: str, password: str = PASSWORD) -> None:
    page.goto(f"{hub.address}/login")
    page.get_by_label("Name").fill(name)
    page.get_by_label("Password").fill(password)
    page.get_by_role("button", name="Sign in", exact=True).click()
    page.wait_for_url(re.compile("/(home|public)$"))


def sign_in_unseen(page: Page, hub: Served, name: str, password: str = PASSWORD) -> None:
    """Sign in as the form does, without the form; no page is opened."""
    answer = page.context.request.post(
        f"{hub.address}/api/login",
        data={"name": name, "password": password},
        headers={"Origin": hub.address},
    )
    assert answer.ok, answer.text()


def open_signed_in(
    page: Page, hub: Served, name: str, password: str = PASSWORD, path: str = ""
) -> None:
    """Sign in without the form: its page costs a browser as much as the next.

    Then opens ``path``, or what the form leads to: to load that first costs as much again.
    """
    sign_in_unseen(page, hub, name, password)
    page.goto(f"{hub.address}{path or '/home'}")
    if not path:
        page.wait_for_url(re.compile("/(home|public)$"))


def visit(
    browser: Browser,
    hub: Served,
    name: str,
    *,
    width: int = 1440,
    height: int = 900,
    scripts: Iterable[str] = (),
    path: str = "",
) -> Page:
    """A person's page, in a browser of their own; see `open_signed_in`."""
    page = browser.new_context(viewport={"width": width, "height": height}).new_page()
    page.set_default_timeout(PATIENCE_MS)
    for each in scripts:
        page.add_init_script(each)
    open_signed_in(page, hub, name, path=path)
    return page


def seen_after(page: Page, begun: float, condition: Callable[[], object]) -> float:
    """Wait until a condition of the page holds; give how long after ``begun`` (monotonic, s).

    Playwright's own `expect` looks only once a second after a while, which is no measure.
    """
    while not condition():
        assert time.monotonic() - begun < PATIENCE_S, "it did not come to that"
        page.wait_for_timeout(20)
    return time.monotonic() - begun


def picture(page: Page, name: str) -> None:
    """Keep what is on screen, where the person who runs the tests wants to look at it."""
    folder = os.environ.get("TALAIA_PICTURES")
    if folder:
        page.screenshot(path=Path(folder) / f"{name}.png")
