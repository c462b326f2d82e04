"""The hub that a request comes to, when another one leads: it hands everything through."""

from __future__ import annotations

import asyncio
import itertools
import logging
from typing import TYPE_CHECKING, Any

from talaia.hub.cluster.frames import FrameKind, TunnelFrame
from talaia.hub.cluster.requests import lane_of, pack_scope
from talaia.hub.cluster.shared_frames import read_shared
from talaia.hub.cluster.tunnel import TunnelBroken, TunnelEnd, TunnelName
from talaia.wire.socket_frame import frame_writer_of

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from starlette.types import Receive, Scope, Send

    from talaia.hub.cluster.bus import BusLane

__all__ = ["Entrance", "NoLead"]

_LOG = logging.getLogger(__name__)
# 1012: the server restarts (RFC 6455's registry); pages and gateways connect again at once.
_RESTARTS = 1012
# A hub that ends sends its sockets away in so many groups at the most, one after each pause (s),
# and no group is smaller than this: the hubs that they go to have time for each.
_GROUPS, _GROUP_PAUSE_S, _SMALLEST_GROUP = 20, 0.25, 4
# All at once of one hub; each costs memory at both ends.
_MOST_OPEN = 20_000


class NoLead(ConnectionError):
    """No hub leads just now, or it cannot be reached from here."""


class Entrance:
    """Hands requests to the hub that leads."""

    def __init__(
        self,
        *,
        find_lead: Callable[[], str | None],
        post: Callable[[TunnelName, BusLane, TunnelFrame], Awaitable[None]],
    ) -> None:
        """Ask ``find_lead`` which hub leads; send to it by ``post``."""
        self._find_lead = find_lead
        self._post = post
        self._numbers = itertools.count(1)
        self._open: dict[TunnelName, TunnelEnd] = {}
        # Those of them that are links of gateways.
        self._gateways: set[TunnelName] = set()

    async def serve_request(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Hand one request through to its end.

        Raises:
            NoLead: nothing was answered yet, and nobody is there to answer.

        """
        lead = self._find_lead()
        if lead is None or len(self._open) >= _MOST_OPEN:
            raise NoLead("no hub leads just now")
        name = TunnelName(lead, next(self._numbers))
        write = frame_writer_of(scope.get("extensions", {}))
        tunnel = TunnelEnd(name, lane_of(scope), scope["type"], post=self._post, write=write)
        self._open[name] = tunnel
        if scope["path"] == "/gateway/link":
            self._gateways.add(name)
        try:
            await self._hand_through(tunnel, scope, receive, send)
        finally:
            del self._open[name]
            self._gateways.discard(name)
            await tunnel.end_tunnel("the asker has gone")

    def receive_frame(self, name: TunnelName, frame: TunnelFrame) -> None:
        """Take a frame of the hub that leads."""
        if frame.kind is FrameKind.SHARED:
            self._receive_shared(name.hub, frame.payload)
            return
        tunnel = self._open.get(name)
        if tunnel is not None:
            tunnel.receive_frame(frame)

    def break_off(self, reason: str, *, but: str | None = None) -> None:
        """End every tunnel, but for those to the hub ``but``."""
        for name, tunnel in list(self._open.items()):
            if name.hub != but:
                tunnel.break_off(reason)

    def break_off_at(self, hub: str, reason: str) -> None:
        """End every tunnel to one hub."""
        for name, tunnel in list(self._open.items()):
            if name.hub == hub:
                tunnel.break_off(reason)

    async def hand_over(self, reason: str, *, pause_s: float = _GROUP_PAUSE_S) -> None:
        """Send all sockets to other hubs, a few at a time; requests are answered to their end."""
        # Those of pages first: whoever drives sees at once that the way changes, and the robot's
        # own link stays until a hub that goes on has the page.
        sockets = sorted(
            (tunnel for tunnel in self._open.values() if tunnel.kind == "websocket"),
            key=lambda tunnel: tunnel.name in self._gateways,
        )
        size = max(_SMALLEST_GROUP, -(-len(sockets) // _GROUPS))
        for first in range(0, len(sockets), size):
            if first:
                await asyncio.sleep(pause_s)
            for tunnel in sockets[first : first + size]:
                # The lead is told, too: what a page holds there is free before it comes again.
                await tunnel.end_tunnel(reason)

    def _receive_shared(self, hub: str, payload: bytes) -> None:
        read = read_shared(payload)
        if read is None:
            # Each of its tunnels sees the hole.
            _LOG.warning("a shared frame of another hub cannot be read")
            return
        takers, frame = read
        for number, sequence in takers:
            tunnel = self._open.get(TunnelName(hub, number))
            if tunnel is not None:
                tunnel.receive_shared(sequence, frame)

    async def _hand_through(
        self, tunnel: TunnelEnd, scope: Scope, receive: Receive, send: Send
    ) -> None:
        answer = _Answer(scope["type"], send)
        try:
            await tunnel.send_open(pack_scope(scope))
        except TunnelBroken as error:
            raise NoLead(str(error)) from error
        upward = asyncio.create_task(_send_upward(tunnel, receive))
        try:
            while (message := await tunnel.receive_message()) is not None:
                await answer.send_message(message)
        finally:
            upward.cancel()
            await asyncio.gather(upward, return_exceptions=True)
        if tunnel.over and not answer.begun:
            raise NoLead(tunnel.over)
        if tunnel.over:
            await answer.break_off()


async def _send_upward(tunnel: TunnelEnd, receive: Receive) -> None:
    """Hand on what the asker says, until they have gone."""
    try:
        while True:
            message = await receive()
            await tunnel.send_message(dict(message))
            if message["type"].endswith(".disconnect"):
                return
    except TunnelBroken as error:
        _LOG.debug("a request is broken off: %s", error)


class _Answer:
    """What has gone to the asker already, which tells how an answer can be ended."""

    def __init__(self, kind: str, send: Send) -> None:
        self._kind = kind
        self._send = send
        self.begun = False
        self._done = False

    async def send_message(self, message: dict[str, Any]) -> None:
        kind = message["type"]
        self.begun = True
        self._done = self._done or kind == "websocket.close"
        if kind.endswith(".response.body"):
            self._done = not message.get("more_body", False)
        if "headers" in message:
            message["headers"] = [(bytes(name), bytes(value)) for name, value in message["headers"]]
        await self._send(message)

    async def break_off(self) -> None:
        """End what cannot be ended well: nobody may take a part of an answer for all of it."""
        if self._done:
            return
        # An HTTP answer that stays without its end is cut off by the server.
        if self._kind == "websocket":
            await self._send({"type": "websocket.close", "code": _RESTARTS})
