"""The support bundle that an admin downloads: ``talaia support-bundle``, run beside the hub."""

from __future__ import annotations

import asyncio
import os
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from fastapi import APIRouter, Request, Response

from talaia.hub.api.access import address_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.child_end import finish_child

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.hub.ports import DescribedSites
    from talaia.hub.settings import Settings
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.sites.descriptions import Descriptions

__all__ = ["SupportBundlePages"]

# What is installed is tried, some of it by loading it (s).
_LONGEST_S = 180.0
# Behind the live values of robots: it is of no hurry.
_NICE = ("nice", "-n", "10")


class SupportBundlePages:
    """The route of the support bundle."""

    def __init__(
        self, *, settings: Settings, sites: DescribedSites, descriptions: Descriptions, audit: Audit
    ) -> None:
        """Make bundles of this hub."""
        self._settings = settings
        self._sites = sites
        self._descriptions = descriptions
        self._audit = audit
        self._making = asyncio.Lock()

    def make_router(self) -> APIRouter:
        """Give the route."""
        router = APIRouter(route_class=GuardedRoute)
        router.post("/api/support-bundle", response_class=Response)(self.bundle)
        return router

    async def bundle(self, request: Request) -> Response:
        """Make a support bundle: one ZIP file for whoever helps, with secrets masked."""
        if self._making.locked():
            raise ApiProblem(409, "busy", "a support bundle is being made; wait for it", 10)
        async with self._making:
            texts = {live.name: await self._text_of(live.name) for live in self._sites}
            made = await self._make_bundle(texts)
        self._audit.append_record(
            "support bundle made",
            who=who_of(request).name,
            address=address_of(request),
            message=f"{len(made)} bytes",
        )
        headers = {"Content-Disposition": 'attachment; filename="talaia-support.zip"'}
        return Response(made, media_type="application/zip", headers=headers)

    async def _text_of(self, site: str) -> str:
        """Give the text that a site goes by; empty where it is not known."""
        newest = await self._descriptions.versions_of(site, most=1)
        return (
            (await self._descriptions.version_text(site, newest[0].number) or "") if newest else ""
        )

    async def _make_bundle(self, texts: Mapping[str, str]) -> bytes:
        # Of its owner alone, and of no name that anybody could lay something at before.
        with tempfile.TemporaryDirectory(prefix="talaia-support-") as name:
            folder = Path(name)
            target = folder / "bundle.zip"
            data, port = str(self._settings.data), str(self._settings.port)
            words = ["support-bundle", str(target), "--data", data, "--port", port]
            for site, text in texts.items():
                if text:
                    file = folder / f"{site}.yaml"
                    file.write_text(text, "utf-8")
                    words += ["--site", str(file)]
            for path in self._settings_files():
                words += ["--settings", str(path)]
            said = await _run_talaia(words, {"TALAIA_DATABASE_URL": self._settings.url})
            if not target.is_file():
                raise ApiProblem(
                    500,
                    "failed",
                    f"no bundle was made: {said or 'it says nothing'}; on the hub's machine try "
                    "`talaia support-bundle`",
                )
            return await asyncio.to_thread(target.read_bytes)

    def _settings_files(self) -> list[Path]:
        """Name the files of settings that this hub was given, with whatever secrets they have."""
        settings = self._settings
        named = (
            *(settings.oidc, settings.mqtt, settings.alpaca, settings.audit_hub),
            settings.history_servers,
        )
        return [path for path in named if path is not None and path.is_file()]


async def _run_talaia(words: Sequence[str], more: Mapping[str, str]) -> str:
    """Run a command of Talaia's; gives the last it said where it failed, else nothing."""
    child = await asyncio.create_subprocess_exec(
        *_NICE,
        *(sys.executable, "-m", "talaia", *words),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.DEVNULL,
        stderr=asyncio.subprocess.PIPE,
        env={**os.environ, **more},
        # A group of its own, so that what it started ends with it.
        start_new_session=True,
    )
    try:
        end = await finish_child(child, _LONGEST_S)
    except TimeoutError:
        return f"it took longer than {_LONGEST_S:g} s"
    return "" if end.code == 0 else end.last_line[:500]
