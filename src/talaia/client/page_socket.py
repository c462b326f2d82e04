"""A WebSocket to the hub that speaks pages' messages, signed in by a token."""

from __future__ import annotations

import asyncio
import itertools
import ssl
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING

from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus, WebSocketException

from talaia.client.errors import HubNotReached, NotSignedIn
from talaia.client.http_requests import refusal_of, untrusted
from talaia.wire.browser import FROM_BROWSER, TO_BROWSER, PagePing, SessionEnded
from talaia.wire.errors import PeerError, UnknownKind

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from websockets.asyncio.client import ClientConnection

    from talaia.client.hub_location import HubLocation
    from talaia.client.hub_trust import CertificateTrust
    from talaia.wire.browser import FromBrowser, ToBrowser

__all__ = ["PageSocket", "open_page_socket"]

_HANDSHAKE_S = 10.0
# The hub answers each of these; after three without a word it is gone (s).
_PING_S = 5.0
_SILENT_S = 15.0


class PageSocket:
    """An open socket; what it raises says that it is lost."""

    def __init__(self, hub: HubLocation, connection: ClientConnection) -> None:
        """Speak over ``connection`` to ``hub``."""
        self._hub = hub
        self._connection = connection

    async def send_message(self, message: FromBrowser) -> None:
        """Send a message.

        Raises:
            HubNotReached: the connection is lost; it is not known whether the hub has it.

        """
        try:
            await self._connection.send(FROM_BROWSER.encode(message))
        except (ConnectionClosed, OSError) as error:
            raise self._lost(error) from error

    async def receive_message(self) -> ToBrowser:
        """Wait for the next message.

        Raises:
            HubNotReached: the connection is lost.
            NotSignedIn: the token is good no more.

        """
        while True:
            try:
                async with asyncio.timeout(_SILENT_S):
                    data = await self._connection.recv()
                message = TO_BROWSER.decode(data)
            # A newer hub may say what this version does not know.
            except UnknownKind:
                continue
            except TimeoutError as error:
                raise HubNotReached(f"{self._hub.page} has not answered for {_SILENT_S:g} s") from (
                    error
                )
            except (ConnectionClosed, OSError, PeerError) as error:
                raise self._lost(error) from error
            if isinstance(message, SessionEnded):
                raise NotSignedIn(
                    "ended",
                    f"the hub ended the connection: {message.reason}",
                    "if the token was revoked or has ended, make another under Account,"
                    f" Tokens for scripts, at {self._hub.page}",
                )
            return message

    async def keep_alive(self) -> None:
        """Let the hub answer from time to time, until cancelled or lost."""
        for number in itertools.count(1):
            await asyncio.sleep(_PING_S)
            with suppress(HubNotReached):
                # Whoever reads is told of the loss.
                await self.send_message(PagePing(n=number, at_ms=0.0))

    def _lost(self, error: Exception) -> HubNotReached:
        return HubNotReached(f"the connection to {self._hub.page} was lost: {error}")


@asynccontextmanager
async def open_page_socket(
    hub: HubLocation, trust: CertificateTrust, path: str, *, needs: str = ""
) -> AsyncIterator[PageSocket]:
    """Open a socket.

    Raises:
        HubNotReached: there is no answer.
        HubUntrusted: it does not prove to be the hub.
        RequestRefused: the hub lets nobody in here with this token.

    """
    context = await asyncio.to_thread(trust.tls_context)
    try:
        connection = await connect(
            hub.socket_url + path,
            ssl=context,
            # Batches are packed columns already.
            compression=None,
            ping_interval=None,
            open_timeout=_HANDSHAKE_S,
            close_timeout=1,
            max_size=TO_BROWSER.max_frame,
            additional_headers={"Authorization": f"Bearer {hub.token}"},
            user_agent_header=None,
            # The token goes to the hub that was named, and by no proxy of the environment.
            proxy=None,
        )
    except InvalidStatus as error:
        answer = error.response
        retry = answer.headers.get("Retry-After", "")
        body = answer.body or b""
        raise refusal_of(hub, answer.status_code, bytes(body), retry=retry, needs=needs) from error
    except ssl.SSLCertVerificationError as error:
        trust.forget_certificate()
        raise untrusted(hub, error) from error
    except (OSError, TimeoutError, WebSocketException) as error:
        trust.forget_certificate()
        said = str(error) or type(error).__name__
        raise HubNotReached(f"{hub.page} cannot be reached: {said}") from error
    pinging = None
    try:
        socket = PageSocket(hub, connection)
        pinging = asyncio.create_task(socket.keep_alive())
        yield socket
    finally:
        if pinging is not None:
            pinging.cancel()
        await connection.close()
