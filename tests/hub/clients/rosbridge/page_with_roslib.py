"""A page of somebody else with npm's roslib, unchanged, served from an origin that is no hub's."""

from __future__ import annotations

import functools
import http.server
import threading
from contextlib import contextmanager

from patience import PATIENCE_MS

from ..tokens import token_of
from .rosbridge_peer import address_of, bundle_roslib

HEAD = """<!doctype html><title>A page with roslib</title><script src="roslib.js"></script>
<script>
const ros = new ROSLIB.Ros();
const told = [];
for (const event of ["connection", "close"]) ros.on(event, () => told.push([event, null]));
"""


class Quiet(http.server.SimpleHTTPRequestHandler):
    """Serves a folder and prints nothing."""

    def log_message(self, *_about: object) -> None:
        """Print nothing."""


@contextmanager
def serve_page(folder, script):
    """Serve a page with roslib connected as ``ros`` and a script of its own; give its origin."""
    bundle_roslib(folder)
    (folder / "index.html").write_text(f"{HEAD}{script}</script>")
    handler = functools.partial(Quiet, directory=folder)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_address[1]}"
        server.shutdown()


async def open_page(chromium, world, origin, name):
    page = await chromium.new_page()
    page.set_default_timeout(PATIENCE_MS)
    await page.goto(origin)
    address = address_of(world.hub, "agv", await token_of(world.hub, name))
    await page.evaluate("(address) => void ros.connect(address)", address)
    return page


async def connected_page(chromium, world, origin, name):
    page = await open_page(chromium, world, origin, name)
    await page.wait_for_function("told.some(([event]) => event === 'connection')")
    return page
