"""The hub that leads: it answers requests that came to other hubs as if they had come here."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Any

import msgspec

from talaia.hub.cluster.frames import FrameKind
from talaia.hub.cluster.requests import takes_shared, unpack_scope
from talaia.hub.cluster.shared_frames import SharedFrames
from talaia.hub.cluster.tunnel import TunnelBroken, TunnelEnd, TunnelName
from talaia.wire.socket_frame import FRAME_WRITER

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, MutableMapping

    from starlette.types import ASGIApp, Scope

    from talaia.hub.cluster.bus import BusLane
    from talaia.hub.cluster.frames import TunnelFrame

__all__ = ["Answering"]

_LOG = logging.getLogger(__name__)
_ABOUT = msgspec.msgpack.Decoder(dict[str, Any])
# Of one hub at once, as its entrance lets in.
_MOST_OPEN = 20_000
_MOST_HUBS = 1_000


class Answering:
    """Runs the application for each request of another hub."""

    def __init__(self, post: Callable[[TunnelName, BusLane, TunnelFrame], Awaitable[None]]) -> None:
        """Answer by ``post``; nothing is answered before `begin_answering`."""
        self._post = post
        self._shared = SharedFrames(post)
        self._app: ASGIApp | None = None
        self._running: dict[TunnelName, tuple[TunnelEnd, asyncio.Task[None]]] = {}
        # By hub, the last number that it opened: what comes again is a replay.
        self._last: dict[str, int] = {}

    def begin_answering(self, app: ASGIApp) -> None:
        """Answer with ``app`` from now on."""
        self._app = app

    async def finish_answering(self, reason: str) -> None:
        """Answer nothing more, and end what is under way."""
        self._app = None
        tasks = [task for _, task in self._running.values()]
        self.break_off(reason)
        if tasks:
            # Applications end by the disconnect that they hear; who does not is cancelled.
            await asyncio.wait(tasks, timeout=0.5)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def receive_frame(self, name: TunnelName, lane: BusLane, frame: TunnelFrame) -> None:
        """Take a frame of another hub."""
        running = self._running.get(name)
        if running is not None:
            running[0].receive_frame(frame)
        elif frame.kind is FrameKind.OPEN and frame.sequence == 0:
            self._open_tunnel(name, lane, frame)
        elif frame.kind is not FrameKind.END:
            # Of one that began with an earlier lead, or is over here: the other end is told.
            self._refuse(name, lane)

    def break_off(self, reason: str, *, hub: str | None = None) -> None:
        """End all requests, or those of one hub: it cannot be heard any more."""
        for name, (tunnel, _) in list(self._running.items()):
            if hub is None or name.hub == hub:
                tunnel.break_off(reason)

    def list_hubs(self) -> set[str]:
        """Name the hubs of which requests are under way."""
        return {name.hub for name in self._running}

    def _open_tunnel(self, name: TunnelName, lane: BusLane, frame: TunnelFrame) -> None:
        app = self._app
        if app is None or len(self._running) >= _MOST_OPEN:
            self._refuse(name, lane)
            return
        # Numbers rise: one that was there before comes from somebody who has recorded it. Two
        # lanes may overtake each other, so each has a count of its own.
        key = f"{name.hub} {lane}"
        if name.number <= self._last.get(key, 0):
            return
        self._last[key] = name.number
        if len(self._last) > _MOST_HUBS:
            # The run that was heard of first is over long since.
            del self._last[next(iter(self._last))]
        try:
            packed = _ABOUT.decode(frame.payload)
            scope = unpack_scope(packed)
        except (msgspec.DecodeError, KeyError, TypeError, ValueError) as error:
            _LOG.warning("a request of another hub cannot be read: %r", error)
            self._refuse(name, lane)
            return
        shared = self._shared if takes_shared(packed) else None
        tunnel = TunnelEnd(name, lane, scope["type"], post=self._post, shared=shared)
        if shared is not None:
            scope["extensions"][FRAME_WRITER] = {"write": tunnel.write_shared}
        tunnel.receive_frame(frame)
        task = asyncio.create_task(self._answer(app, scope, tunnel))
        self._running[name] = tunnel, task
        task.add_done_callback(lambda _: self._running.pop(name, None))

    def _refuse(self, name: TunnelName, lane: BusLane) -> None:
        tunnel = TunnelEnd(name, lane, "http", post=self._post)
        refusing = asyncio.create_task(tunnel.end_tunnel("the hub does not lead"))
        # Kept until it is done: the loop holds tasks only weakly.
        self._running[name] = tunnel, refusing
        refusing.add_done_callback(lambda _: self._running.pop(name, None))

    async def _answer(self, app: ASGIApp, scope: Scope, tunnel: TunnelEnd) -> None:
        disconnect = f"{scope['type']}.disconnect"

        async def receive_message() -> MutableMapping[str, Any]:
            message = await tunnel.receive_message()
            if message is None:
                # 1006: it broke off (RFC 6455, 7.4.1).
                return {"type": disconnect, "code": 1006}
            return message

        async def send_message(message: MutableMapping[str, Any]) -> None:
            await tunnel.send_message(dict(message))

        reason = ""
        try:
            await app(scope, receive_message, send_message)
        except TunnelBroken as error:
            _LOG.debug("an answer is broken off: %s", error)
        except Exception:  # noqa: BLE001 - one request must not take the others with it
            reason = "the answer failed"
            if tunnel.over:
                # Whoever asked was gone before the answer, which applications may not expect.
                _LOG.debug("an answer that nobody waits for failed", exc_info=True)
            else:
                _LOG.exception("the answer to a request of another hub failed")
        finally:
            await tunnel.end_tunnel(reason)
