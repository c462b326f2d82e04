"""One script that drives: it speaks pages' messages, and is held to the rules of other tools.

Everything else a script does goes over ``/ws`` and the HTTP API. Driving has a socket of its own,
because a script is no page: its lease, its speed and its zeros are kept here (`ClientDriving`), and
an admin decides whether it may at all.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.wire.browser import (
    FROM_BROWSER,
    TO_BROWSER,
    PageDrive,
    PageLease,
    PagePing,
    PageStop,
    RequestError,
    TickUpdate,
)
from talaia.wire.errors import UnknownKind
from talaia.wire.frames import LeaseOp

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

    from talaia.hub.clients.client_connection import ClientConnection
    from talaia.wire.browser import FromBrowser, ToBrowser

__all__ = ["ScriptSession"]

_ELSEWHERE = "this socket is for driving; the rest is asked over /ws"
_HELD_HERE = "the hub takes the lease with the first velocity, and gives it back"


class ScriptSession:
    """See `ClientSession`."""

    def __init__(self, socket: WebSocket, connection: ClientConnection) -> None:
        """Speak MessagePack over ``socket``, which is accepted, for ``connection``."""
        self._socket = socket
        self._connection = connection
        self._site = connection.live.name

    async def read_client(self) -> None:
        """Read until the script has gone."""
        while True:
            event = await self._socket.receive()
            if event["type"] == "websocket.disconnect":
                return
            data = event.get("bytes")
            try:
                message = FROM_BROWSER.decode(event.get("text", "") if data is None else data)
            except UnknownKind as error:
                await self._refuse_message("unknown", str(error), error.kind[:200])
                continue
            await self._handle_message(message)

    async def deliver_message(self, message: ToBrowser) -> None:
        """Write a message of the hub: how leases, drives, STOP and interlocks stand."""
        # The hub echoes the gateway's marks itself: 20 of them a second would be for nothing.
        if isinstance(message, TickUpdate):
            return
        await self._socket.send_bytes(TO_BROWSER.encode(message))

    async def warn_person(self, text: str) -> None:
        """Say why the script does not drive, or no longer."""
        await self._refuse_message("driving", text, "drive")

    async def close_client(self, code: int) -> None:
        """Close the socket."""
        await self._socket.close(code)

    async def _handle_message(self, message: FromBrowser) -> None:
        about = str(type(message).__struct_config__.tag)
        site = message.subject().site
        if site and site != self._site:
            await self._refuse_message("unknown", f"this socket is of {self._site!r}", about)
            return
        match message:
            case PageDrive():
                # Its epoch, number and time mark are not read: the hub has its own.
                why = self._connection.publish_drive(
                    message.device,
                    linear=message.linear,
                    angular=message.angular,
                    lateral=message.lateral,
                )
                if why:
                    await self._refuse_message("driving", why, about)
            case PageLease(op=LeaseOp.FREE):
                self._connection.release_drive(message.device)
            case PageLease():
                await self._refuse_message("driving", _HELD_HERE, about)
            case PageStop() | PagePing():
                problem = self._connection.request(message)
                if problem is not None:
                    await self.deliver_message(problem)
            case _:
                await self._refuse_message("elsewhere", _ELSEWHERE, about)

    async def _refuse_message(self, code: str, why: str, about: str) -> None:
        await self.deliver_message(RequestError(code=code, message=why, about=about))
