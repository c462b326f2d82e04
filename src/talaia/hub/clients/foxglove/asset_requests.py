"""Files of robots, such as meshes, that Foxglove clients fetch."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.hub.auth.permissions import Right
from talaia.hub.errors import AssetMissing, AssetRefused
from talaia.wire.foxglove.codec import encode_asset

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from talaia.hub.auth.permissions import Grants
    from talaia.hub.live.assets.robot_assets import RobotAssets
    from talaia.wire.foxglove.client_messages import FoxgloveFetchAsset

__all__ = ["AssetRequests"]

# Requests of one client that wait.
_MOST_WAITING = 1000


class AssetRequests:
    """The requests of one client: one after the other, beside all else that it is sent.

    Attributes:
        capabilities: what the client is told of it.

    """

    def __init__(
        self,
        assets: RobotAssets,
        site: str,
        grants: Grants,
        *,
        send: Callable[[bytes], Awaitable[None]],
    ) -> None:
        """Answer by ``send``; who may view no device of the site gets no file of its robots."""
        self._assets, self._grants = assets, grants
        self._site = site
        # None stands for all devices.
        devices = grants.devices(Right.VIEW, site)
        self._allowed = devices is None or bool(devices)
        self._send = send
        # Beside the session: a large file on a slow line must not hold up STOP.
        self._waiting: asyncio.Queue[FoxgloveFetchAsset] = asyncio.Queue(_MOST_WAITING)
        self.capabilities = ["assets"] if self._allowed and assets.serves_site(site) else []

    async def fetch_asset(self, asked: FoxgloveFetchAsset) -> None:
        """Answer a request when those before it are answered."""
        try:
            self._waiting.put_nowait(asked)
        except asyncio.QueueFull:
            why = f"at most {_MOST_WAITING} files at once"
            await self._send(encode_asset(asked.request_id, None, why))

    async def serve_requests(self) -> None:
        """Answer what is asked, until cancelled."""
        while True:
            asked = await self._waiting.get()
            await self._send(await self._answer(asked))

    async def _answer(self, asked: FoxgloveFetchAsset) -> bytes:
        try:
            if not self._allowed:
                raise AssetMissing
            found = await self._assets.read_asset(self._site, asked.uri, self._grants)
        except AssetRefused as refused:
            return encode_asset(asked.request_id, None, str(refused))
        return encode_asset(asked.request_id, found.data)
