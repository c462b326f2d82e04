"""How the hub proves itself: a pinned certificate, a given CA, or the system's trust."""

from __future__ import annotations

import asyncio
import hashlib
import ssl
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from talaia.certificate_pin import has_fingerprint, trust_only
from talaia.gateway.errors import LinkLost, SettingsError

if TYPE_CHECKING:
    from talaia.gateway.settings import HubAddress

__all__ = ["HubTrust"]


class HubTrust:
    """Makes the TLS context for a hub.

    With a fingerprint (of the certificate, or of its public key, which a renewal keeps), the
    certificate is fetched once without telling the hub anything, compared, and from then on is the
    only one TLS accepts. So the key is never sent to an impostor, as it
    would be if the fingerprint were looked at after the request.
    """

    def __init__(self, hub: HubAddress) -> None:
        """Take the address and how it is to be trusted."""
        self._hub = hub  # Address, and fingerprint or CA if there is one.
        self._urls = (hub.url, *hub.others)  # Of hubs that are one.
        self._at = 0  # Which of them is dialled.
        self._context: ssl.SSLContext | None = None  # Made at the first dial, kept until `forget`.

    @property
    def url(self) -> str:
        """The address to dial: of the hub that was reached last, or the next in turn."""
        return self._urls[self._at]

    def turn_away(self, url: str) -> None:
        """Dial another hub next time, if there is one; unless somebody has seen to it already."""
        if url == self.url:
            self._at = (self._at + 1) % len(self._urls)
            self.forget()

    async def context(self) -> ssl.SSLContext | None:
        """Give the context; none for plain text.

        Raises:
            LinkLost: the hub is not there, or shows another certificate than the pinned one.
            SettingsError: the CA file cannot be used.

        """
        if self._hub.plain:
            return None
        if self._context is None:
            self._context = await self._pinned() if self._hub.fingerprint else self._by_authority()
        return self._context

    def _by_authority(self) -> ssl.SSLContext:
        try:
            return ssl.create_default_context(
                cafile=str(self._hub.ca) if self._hub.ca is not None else None
            )
        except OSError as error:
            raise SettingsError(f"--ca {self._hub.ca}: {error}") from error

    async def _pinned(self) -> ssl.SSLContext:
        shown = await self.shown()
        found = hashlib.sha256(shown).hexdigest()
        if not has_fingerprint(shown, self._hub.fingerprint):
            raise LinkLost(
                f"{self.url} shows the certificate {found}, which is not the one that this "
                f"gateway knows ({self._hub.fingerprint}); if the hub was set up anew, enrol this "
                "gateway again with a code from its page, else somebody stands between"
            )
        return trust_only(shown)

    async def shown(self) -> bytes:
        """Fetch the certificate (DER) that the hub shows, without telling it anything.

        Raises:
            LinkLost: the hub is not there, or speaks no TLS.

        """
        url = self.url
        parts = urlsplit(url)
        # Nothing is verified here and nothing is sent: the certificate is only looked at.
        looking = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        looking.check_hostname = False
        looking.verify_mode = ssl.CERT_NONE
        try:
            async with asyncio.timeout(5):
                _, writer = await asyncio.open_connection(
                    parts.hostname, parts.port or 443, ssl=looking
                )
        except (OSError, TimeoutError) as error:
            reason = str(error) or "no answer"
            raise LinkLost(f"{url} cannot be reached: {reason}") from error
        try:
            peer: ssl.SSLObject = writer.get_extra_info("ssl_object")
            return peer.getpeercert(binary_form=True) or b""
        finally:
            # Not closed politely: a TLS goodbye would wait for a peer that may be anybody.
            writer.transport.abort()

    def forget(self) -> None:
        """Look again next time: the hub's certificate may have been renewed to the pinned one."""
        self._context = None
