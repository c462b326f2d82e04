"""Leads each request to the shard that it is for."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING

from talaia.hub.errors import StoreDown
from talaia.hub.sharding.addressing import AskedObject, read_address
from talaia.hub.sharding.merged_lists import MergedLists
from talaia.hub.sharding.page_join import PageJoin
from talaia.hub.sharding.plan import MAIN

if TYPE_CHECKING:
    from collections.abc import Awaitable, Mapping

    from starlette.types import ASGIApp, Receive, Scope, Send

    from talaia.hub.sharding.addressing import Address
    from talaia.hub.sharding.directory import ShardDirectory

__all__ = ["ShardRouter"]


class ShardRouter:
    """An ASGI app before those of all shards."""

    def __init__(self, apps: Mapping[str, ASGIApp], directory: ShardDirectory) -> None:
        """Lead to ``apps``, by the shard's name; ``directory`` says which site is whose."""
        self._apps = apps
        self._directory = directory
        self._join = PageJoin(apps, self._shard_of)
        self._lists = MergedLists(apps, self._shard_of)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or serve a socket, to its end."""
        address = read_address(scope)
        if address.about is AskedObject.PAGE:
            await self._join.serve(scope, receive, send)
        elif (
            address.about is AskedObject.HUB
            and scope["type"] == "http"
            and self._lists.takes(scope["method"], scope["path"])
        ):
            await self._lists.serve(scope, receive, send)
        else:
            await self._apps[await self._find_shard(address)](scope, receive, send)

    def _shard_of(self, site: str) -> Awaitable[str] | str:
        # At once where it is known: driving frames are led by it.
        return self._directory.known_shard(site) or self._directory.find_shard(site)

    async def _find_shard(self, address: Address) -> str:
        # What is about no site that is known is the main shard's to answer. So it is while the
        # database is away: it says so as it does of everything else.
        with contextlib.suppress(StoreDown):
            match address.about:
                case AskedObject.SITE:
                    return await self._directory.find_shard(address.name)
                case AskedObject.NEW_SITE:
                    return await self._directory.place_site(address.name)
                case AskedObject.KEY:
                    site = await self._directory.find_site_of_key(address.name)
                    return MAIN if site is None else await self._directory.place_site(site)
                case AskedObject.GATEWAY:
                    site = await self._directory.find_site_of_gateway(int(address.name))
                    return MAIN if site is None else await self._directory.find_shard(site)
                case AskedObject.HUB | AskedObject.PAGE:
                    return MAIN
        return MAIN
