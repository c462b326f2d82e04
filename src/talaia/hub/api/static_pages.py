"""The dashboard's own files: one page for every path, and its assets."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from fastapi import APIRouter, Request
from fastapi.responses import FileResponse, HTMLResponse, Response

from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import problem_response

__all__ = ["Pages"]

if TYPE_CHECKING:
    from collections.abc import Mapping

# The names of assets hold a hash of their content.
_FOREVER = {"Cache-Control": "public, max-age=31536000, immutable"}
# May be kept, but is asked about each time: a new version of the hub has new files.
_FRESH = {"Cache-Control": "no-cache"}
# Browsers ask for the page's icon each time that its address changes, as it does with each moment.
_ICONS = {"Cache-Control": "public, max-age=3600"}
_ICON_KINDS = {".ico", ".png", ".svg"}
# Said here, since the system's own table differs from machine to machine. No other file goes out.
_KINDS: Mapping[str, str] = {
    ".css": "text/css; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".ico": "image/x-icon",
    ".jpg": "image/jpeg",
    ".js": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".mjs": "text/javascript; charset=utf-8",
    ".pbf": "application/x-protobuf",
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".ttf": "font/ttf",
    ".txt": "text/plain; charset=utf-8",
    ".wasm": "application/wasm",
    ".webmanifest": "application/manifest+json",
    ".webp": "image/webp",
    ".woff2": "font/woff2",
}
_NOT_BUILT = (
    "<!doctype html><html lang=en><meta charset=utf-8><title>Talaia</title>"
    "<h1>The pages are not built</h1><p>The hub runs. Build the dashboard with"
    " <code>make pages</code> and load this page again."
)


class Pages:
    """Files of one folder, and nothing outside it."""

    def __init__(self, folder: Path) -> None:
        """Serve what is in ``folder``."""
        # Without links, so that what is found can be held against it.
        self._folder = folder.resolve()

    def make_router(self) -> APIRouter:
        """Give the route; it takes every path that no other route took."""
        router = APIRouter(route_class=GuardedRoute)
        # Files for browsers are no part of the API's description.
        router.api_route(
            "/{path:path}", methods=["GET", "HEAD"], response_model=None, include_in_schema=False
        )(self.page)
        return router

    def page(self, request: Request, path: str) -> Response:
        """Give a file, or the one page for every path that is no file's."""
        # A program that mistypes an address must get no page with status 200.
        if path.startswith(("api/", "gateway/")) or path in {
            "api",
            "ws",
            "ws/media",
            "ws/media/unblurred",
            "ws/topic",
        }:
            return problem_response(404, "unknown", "there is nothing here")
        found = self._find_file(path)
        if found is not None and found.name != "index.html":
            named = _ICONS if found.suffix in _ICON_KINDS else _FRESH
            headers = _FOREVER if path.startswith("assets/") else named
            return self._file_response(request, found, headers)
        # A file of a former version: the page in its place would be run as a script.
        if path.startswith("assets/") or (found is None and Path(path).suffix in _KINDS):
            return problem_response(404, "unknown", "there is no such file")
        index = self._folder / "index.html"
        if not index.is_file():
            return HTMLResponse(_NOT_BUILT, 503)
        return self._file_response(request, index, _FRESH)

    def _find_file(self, path: str) -> Path | None:
        # The system raises at a NUL, and a backslash parts folders on some.
        if "\0" in path or "\\" in path:
            return None
        # Resolved first: ``..``, an absolute path and a link all end where they really lead.
        found = (self._folder / path).resolve()
        if found.suffix not in _KINDS or not found.is_relative_to(self._folder):
            return None
        return found if found.is_file() else None

    def _file_response(self, request: Request, found: Path, headers: Mapping[str, str]) -> Response:
        kind = _KINDS[found.suffix]
        # Packed when the pages were built; nothing is packed while somebody waits.
        zipped = found.with_name(found.name + ".gz")
        if zipped.is_file():
            # Of both forms, so that no cache gives the packed one to who cannot read it.
            headers = {**headers, "Vary": "Accept-Encoding"}
            if "gzip" in request.headers.get("accept-encoding", ""):
                packed = {**headers, "Content-Encoding": "gzip"}
                return FileResponse(zipped, headers=packed, media_type=kind)
        return FileResponse(found, headers=dict(headers), media_type=kind)
