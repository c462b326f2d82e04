"""A few pages in a real Chromium before several hubs, in a process of their own.

    python -m system.cluster.browser_pages PORT COOKIE SITE...

Each shows the device of one gateway of the crowd, and is never loaded again: whatever becomes of
the hubs, it has to go on by itself. Words on stdin are those of `crowd`: ``fault`` begins to
measure how long each shows nothing new; ``report`` is answered by a line of JSON once each has
shown something new since it was asked; the end of stdin ends all. ``open`` is said at the start.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time
from pathlib import Path

from browser_program import FLAGS, find_browser
from patience import PATIENCE_MS, PATIENCE_S
from playwright.async_api import Error, Page, async_playwright

from .crowd import Silence

# Between two looks at what a page shows (s).
LOOK_S = 0.2
# The value, and whether the page says that it is of now; empty while there is none.
SHOWN = """
() => {
  const found = [];
  const walk = (root) => {
    for (const element of root.querySelectorAll("*")) {
      if (element.localName === "t-value") found.push([element.value, element.state]);
      if (element.shadowRoot !== null) walk(element.shadowRoot);
    }
  };
  walk(document);
  return found;
}
"""


class BrowserPage:
    """One page of a person who looks at a device."""

    def __init__(self, page: Page) -> None:
        """Look at a page that is open."""
        self._page = page
        self.silence = Silence()
        self.newest = -1.0
        # How often it showed, as one of now, an older value than before.
        self.went_back = 0

    async def look(self) -> None:
        """See what it shows."""
        for value, state in await self._page.evaluate(SHOWN):
            if state != "live" or not isinstance(value, int | float):
                continue
            if value < self.newest:
                self.went_back += 1
            elif value > self.newest:
                self.newest = float(value)
                self.silence.hear()

    async def look_on(self) -> None:
        """See what it shows, for ever."""
        while True:
            await self.look()
            await asyncio.sleep(LOOK_S)


async def open_pages(address: str, cookie: str, sites: list[str]) -> list[BrowserPage]:
    """Open a page for each site, and wait until it shows a value.

    Raises:
        LookupError: there is no Chromium.

    """
    program = find_browser()
    if not program:
        raise LookupError("no Chromium")
    play = await async_playwright().start()
    browser = await play.chromium.launch(executable_path=program, args=FLAGS)
    context = await browser.new_context()
    for pair in cookie.split("; "):
        name, _, value = pair.partition("=")
        await context.add_cookies([{"name": name, "value": value, "url": address}])
    pages = []
    for site in sites:
        page = await context.new_page()
        page.set_default_timeout(PATIENCE_MS)
        await page.goto(f"{address}/sites/{site}/devices/hut")
        pages.append(BrowserPage(page))
    return pages


async def report(pages: list[BrowserPage]) -> str:
    """Wait until each has shown something new; give what they have seen."""
    before = [page.newest for page in pages]
    ends = time.monotonic() + PATIENCE_S

    def blind() -> list[int]:
        return [at for at, page in enumerate(pages) if page.newest <= before[at]]

    while blind() and time.monotonic() < ends:  # noqa: ASYNC110
        await asyncio.sleep(LOOK_S)
    return json.dumps(
        {
            "blind": len(blind()),
            "went_back": sum(page.went_back for page in pages),
            "pages_s": [page.silence.longest_s for page in pages],
        }
    )


async def main(address: str, cookie: str, sites: list[str]) -> None:
    """Stay until stdin ends."""
    pages = await open_pages(address, cookie, sites)
    sys.stdout.write("open\n")
    sys.stdout.flush()
    looking = [asyncio.create_task(page.look_on()) for page in pages]
    while line := (await asyncio.to_thread(sys.stdin.readline)).strip():
        if broken := next((task for task in looking if task.done()), None):
            broken.result()
        if line == "fault":
            for page in pages:
                page.silence.begin_fault()
        else:
            sys.stdout.write(f"report {await report(pages)}\n")
            sys.stdout.flush()


if __name__ == "__main__":
    try:
        asyncio.run(
            main(f"http://localhost:{sys.argv[1]}", Path(sys.argv[2]).read_text(), sys.argv[3:])
        )
    except Error as error:
        # Its browser was ended with it.
        sys.exit(str(error))
