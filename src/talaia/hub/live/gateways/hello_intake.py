"""The first message of a link, and whether a gateway may speak for the site that it names."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.hub.live.gateways.fingerprint import fingerprint_of
from talaia.model.checks.site_checks import raise_first
from talaia.model.yaml_text.load import load_site
from talaia.wire import frames
from talaia.wire.errors import PeerError
from talaia.wire.message import is_compatible

if TYPE_CHECKING:
    from talaia.hub.live.gateways.link import GatewayLink
    from talaia.hub.live.sites import LiveSite
    from talaia.model.site import Site

__all__ = ["REFUSED", "receive_hello"]

# Codes from 4000 on are left to applications (RFC 6455, 7.4.2).
REFUSED = 4400


async def receive_hello(
    link: GatewayLink, live: LiveSite | None, site: str, within_s: float
) -> tuple[frames.Hello | None, Site | None]:
    """Wait for a gateway's hello; None: it has hung up without a word.

    Args:
        link: says it.
        live: what is known of the site that its key is for; none: nothing.
        site: that site.
        within_s: so long it may take (s).

    Raises:
        PeerError: it is none, or is for another site or another version of the hub.
        DescriptionError: the description in it has mistakes.
        TimeoutError: it has not come in time.

    """
    async with asyncio.timeout(within_s):
        hello = await link.receive_message()
    if hello is None:
        return None, None
    if not isinstance(hello, frames.Hello):
        raise PeerError("expected hello as the first message", REFUSED)
    if not is_compatible(hello.protocol):
        raise PeerError(f"protocol {hello.protocol} is not spoken here; update", REFUSED)
    # A key is for one site: otherwise a gateway could speak for another's robots.
    if hello.site != site:
        raise PeerError(f"this key is for the site {site!r}, not {hello.site!r}", REFUSED)
    told = fingerprint_of(hello.description, hello.catalogue)
    if live is not None and live.gateway.fingerprint == told:
        # Word for word what it said before: there is nothing to read.
        return hello, live.description
    # A large description takes a while to read: not in the way of the others.
    description = await asyncio.to_thread(_read_site, hello.description)
    # The site is named in the description too, and that one must fit the key as well.
    if description.site != site:
        raise PeerError(f"the description is of {description.site!r}, not {site!r}", REFUSED)
    return hello, description


def _read_site(text: str) -> Site:
    return raise_first(load_site(text))
