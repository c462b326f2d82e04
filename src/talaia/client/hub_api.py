"""The hub's API as the parts of a client ask it: without blocking, and again where that is safe."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, TypeVar

from talaia.client.addresses import match_sites, qualify_address
from talaia.client.errors import TooManyRequests
from talaia.client.http_requests import HttpRequests, quote_segment
from talaia.client.hub_trust import CertificateTrust
from talaia.client.page_socket import open_page_socket
from talaia.client.values import SiteInfo, SiteOverview

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from contextlib import AbstractAsyncContextManager

    from talaia.client.hub_location import HubLocation
    from talaia.client.page_socket import PageSocket

__all__ = ["HubApi"]

# A request that only reads is asked again so often when the hub says that it was too much.
_TRIES = 4
_LONGEST_WAIT_S = 30.0

T = TypeVar("T")


class HubApi:
    """One hub, with one token.

    Attributes:
        hub: where it is.
        requests: asks it, and blocks.

    """

    def __init__(self, hub: HubLocation) -> None:
        """Ask ``hub``; nothing is sent before something is asked."""
        self.hub = hub
        # One for both: what was pinned for one counts for the other.
        self._trust = CertificateTrust(hub)
        self.requests = HttpRequests(hub, self._trust)

    async def get_json(
        self, kind: type[T], path: str, *, query: Sequence[tuple[str, str]] = (), needs: str = ""
    ) -> T:
        """Ask for what is read as ``kind``; ``needs`` says which right it takes.

        Raises:
            ClientError: the hub cannot be asked, or says no.

        """
        return await self.read_again(
            lambda: self.requests.get_json(kind, path, query=query, needs=needs)
        )

    async def read_again(self, read: Callable[[], T]) -> T:
        """Read something in a thread, and again if the hub says that it was asked too much.

        Raises:
            ClientError: the hub cannot be asked, or says no.

        """
        for _ in range(_TRIES - 1):
            try:
                return await asyncio.to_thread(read)
            except TooManyRequests as error:
                if error.retry_s > _LONGEST_WAIT_S:
                    raise
                await asyncio.sleep(error.retry_s)
        return await asyncio.to_thread(read)

    async def send_json(self, method: str, path: str, body: object, *, needs: str = "") -> None:
        """Ask for something to be done, once and never again by itself.

        Raises:
            ClientError: the hub cannot be asked, or says no.

        """
        await asyncio.to_thread(self.requests.send_json, method, path, body, needs=needs)

    async def list_sites(self) -> list[SiteOverview]:
        """List the sites that the token may see.

        Raises:
            ClientError: the hub cannot be asked, or says no.

        """
        return await self.get_json(list[SiteOverview], "/api/sites")

    async def describe_site(self, site: str) -> SiteInfo:
        """Describe a site as far as the token may see it.

        Raises:
            ClientError: the hub cannot be asked, or says no.

        """
        return await self.get_json(SiteInfo, f"/api/sites/{quote_segment(site)}")

    async def qualify_addresses(self, addresses: Sequence[str], *, parts: int = 3) -> list[str]:
        """Give addresses with their sites.

        Raises:
            ClientError: one is no address, or the hub cannot be asked.

        """
        # Asked only where it matters: most scripts name the site.
        named = all(address.count("/") == parts - 1 for address in addresses)
        sites = [] if named else [found.site for found in await self.list_sites()]
        return [qualify_address(address, sites, parts=parts) for address in addresses]

    async def describe_sites_of(self, addresses: Sequence[str]) -> list[SiteInfo]:
        """Describe the sites that qualified addresses mean.

        Raises:
            ClientError: one means none, or the hub cannot be asked.

        """
        sites = [found.site for found in await self.list_sites()]
        return [await self.describe_site(site) for site in match_sites(addresses, sites)]

    def open_socket(self, path: str, *, needs: str = "") -> AbstractAsyncContextManager[PageSocket]:
        """Open a socket; see `open_page_socket`."""
        return open_page_socket(self.hub, self._trust, path, needs=needs)
