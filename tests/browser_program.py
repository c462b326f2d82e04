"""Which Chromium the tests drive.

Without a window to draw, the headless shell does what Chromium does with a page, by the same code,
for half of the computing: most of what the browser's own process does is its window. Chromium
itself is for what a page only finds there (`CHROMIUM`), and where there is no shell.
"""

from __future__ import annotations

import shutil

CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
SHELL = "chromium-headless-shell"


def find_browser(names: tuple[str, ...] = (SHELL, *CHROMIUM)) -> str | None:
    """Find the first of these programs on this machine."""
    return next((path for name in names if (path := shutil.which(name))), None)
