"""Meshes of robots for the pages that draw them; see `RobotAssets`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response

from talaia.hub.api.access import who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.auth.permissions import Right
from talaia.hub.errors import AssetRefused

if TYPE_CHECKING:
    from talaia.hub.live.assets.robot_assets import RobotAssets

__all__ = ["AssetPages"]

_Uri = Annotated[str, Query(max_length=1000)]


class AssetPages:
    """The route of a robot's files."""

    def __init__(self, assets: RobotAssets) -> None:
        """Answer from what the hub has or gets."""
        self._assets = assets

    def router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/sites/{site}/assets", response_class=Response)(self.file)
        return router

    async def file(self, site: str, uri: _Uri, request: Request) -> Response:
        """Download a file of a robot's packages, such as a mesh, by its URI ``package://…``.

        It comes from the hub's folder of files, or from the robot by its gateway, if the robot's
        description names it. Kept by the browser as long as its content (``ETag``) stays the same.
        """
        grants = who_of(request).grants
        devices = grants.devices(Right.VIEW, site)
        # None stands for all devices. Who may view none learns of no file.
        if devices is not None and not devices:
            raise ApiProblem(404, "unknown", "there is no such file")
        try:
            found = await self._assets.read_asset(site, uri, grants)
        except AssetRefused as refused:
            raise ApiProblem(404, "unknown", str(refused)) from refused
        tag = f'"{found.digest}"'
        headers = {
            "ETag": tag,
            # Asked again each time, and sent again only when it is another.
            "Cache-Control": "private, no-cache",
            "Content-Disposition": "attachment",
        }
        if request.headers.get("if-none-match") == tag:
            return Response(status_code=304, headers=headers)
        return Response(found.data, media_type="application/octet-stream", headers=headers)
