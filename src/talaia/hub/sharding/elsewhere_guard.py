"""Sends whoever asks a lead about a site of another shard away, to ask again.

Hubs in front learn within half a second that a site has changed its shard. What they lead here
until then must not be answered as if there were no such site.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from talaia.hub.errors import StoreDown
from talaia.hub.sharding.addressing import AskedObject, read_address

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Receive, Scope, Send

__all__ = ["ElsewhereGuard"]


class SomeShard(Protocol):
    """Knows which sites it has."""

    async def look_up(self, site: str) -> bool:
        """Tell whether it has a site; may raise `StoreDown`."""
        ...


class ElsewhereGuard:
    """An ASGI app before that of a shard's lead."""

    def __init__(self, app: ASGIApp, shard: SomeShard, refuse: ASGIApp) -> None:
        """Let ``app`` answer for the sites that ``shard`` has, and for all that is of no site.

        ``refuse`` answers for sites of other shards.
        """
        self._app, self._refuse = app, refuse
        self._shard = shard

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or refuse."""
        address = read_address(scope)
        # Gateways are looked at as they prove their key.
        if address.about is AskedObject.SITE and not await self._has_site(address.name):
            await self._refuse(scope, receive, send)
        else:
            await self._app(scope, receive, send)

    async def _has_site(self, site: str) -> bool:
        try:
            return await self._shard.look_up(site)
        except StoreDown:
            # It says so as it does of everything else.
            return True
