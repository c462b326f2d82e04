"""Which Chromium the tests drive, and how it is started: here, by the benches and for pictures.

Without a window to draw, the headless shell does what Chromium does with a page, by the same code,
for half of the computing: most of what the browser's own process does is its window. Chromium
itself is for what a page only finds there (`CHROMIUM`), and where there is no shell.
"""

from __future__ import annotations

import shutil

CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
SHELL = "chromium-headless-shell"
FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
# Draws in space by software, where there is no graphics hardware either: only what a page draws by
# WebGL, as Chromium itself chooses there. With "--use-angle=swiftshader" it would take that program
# for graphics hardware and have it draw all of each page, its 2D canvases too; then a frame of a
# board takes half a second of a core, whatever the page does.
SPACE_FLAGS = [
    *(flag for flag in FLAGS if flag != "--disable-gpu"),
    "--enable-unsafe-swiftshader",
]


def find_browser(names: tuple[str, ...] = (SHELL, *CHROMIUM)) -> str | None:
    """Find the first of these programs on this machine."""
    return next((path for name in names if (path := shutil.which(name))), None)
