"""Requests that came to the hub that leads itself: they end when its hub closes to open again."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import MutableMapping

    from starlette.types import ASGIApp, Receive, Scope, Send

__all__ = ["LocalRequests"]

_LOG = logging.getLogger(__name__)

# 1012: the server restarts (RFC 6455's registry); pages and gateways connect again at once.
_RESTARTS = 1012
# Of HTTP: what an application answers whose database is closed.
_FAILED = 500
# Applications end by the disconnect that they hear within this (s); who does not is cancelled.
_ENDING_S = 0.5


class _LocalRequest:
    """One request, whose application hears at any moment that nobody is there any more."""

    def __init__(self, scope: Scope, receive: Receive, send: Send) -> None:
        self._kind: str = scope["type"]
        self._receive, self._send = receive, send
        self._over = asyncio.Event()
        self._hearing: asyncio.Future[MutableMapping[str, Any]] | None = None
        # Of a socket: it was let in, and has not been closed here.
        self._open = False
        # Something of an answer has gone out.
        self.answered = False
        # All of them end; what fails because of that is no answer.
        self.ends = self._failed = False

    async def receive(self) -> MutableMapping[str, Any]:
        if self._over.is_set():
            return self._gone()
        self._hearing = asyncio.ensure_future(self._receive())
        heard = self._hearing
        try:
            # Whoever ends this request cancels what is heard, and not the application.
            await asyncio.wait((heard,))
        except asyncio.CancelledError:
            heard.cancel()
            raise
        self._hearing = None
        return self._gone() if heard.cancelled() else heard.result()

    async def send(self, message: MutableMapping[str, Any]) -> None:
        kind = message["type"]
        if kind == "http.response.start" and self.ends and message["status"] == _FAILED:
            self._failed = True
        if self._failed:
            return
        self.answered = True
        if kind == "websocket.accept":
            self._open = True
        elif kind == "websocket.close":
            self._open = False
        await self._send(message)

    def break_off(self) -> None:
        self.ends = True
        if self._kind != "websocket":
            # Most are answered within the time that there is.
            return
        self._over.set()
        if self._hearing is not None:
            self._hearing.cancel()

    async def close_socket(self) -> None:
        """Send who is in a socket away, who may have gone meanwhile."""
        if self._over.is_set() and self._open:
            with contextlib.suppress(OSError, RuntimeError):
                await self._send({"type": "websocket.close", "code": _RESTARTS})

    def _gone(self) -> MutableMapping[str, Any]:
        return {"type": f"{self._kind}.disconnect", "code": 1006}


class LocalRequests:
    """Runs an application for whoever came here, until they go or all of it ends."""

    def __init__(self) -> None:
        """Have none."""
        self._running: dict[_LocalRequest, asyncio.Task[None]] = {}

    async def serve(self, app: ASGIApp, scope: Scope, receive: Receive, send: Send) -> bool:
        """Let ``app`` answer a request to its end, which may be `end_all`.

        Returns:
            False: it came to an end by that before anything was answered.

        """
        request = _LocalRequest(scope, receive, send)
        task = asyncio.ensure_future(app(scope, request.receive, request.send))
        self._running[request] = task
        try:
            await asyncio.wait((task,))
        except asyncio.CancelledError:
            # The server ends it.
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)
            raise
        finally:
            del self._running[request]
        if not request.ends:
            task.result()
            return True
        await request.close_socket()
        if not task.cancelled() and (error := task.exception()) is not None:
            _LOG.debug("a request failed as its hub closed: %r", error)
        return request.answered

    async def end_all(self) -> None:
        """End all that are under way."""
        tasks = list(self._running.values())
        for request in list(self._running):
            request.break_off()
        if tasks:
            await asyncio.wait(tasks, timeout=_ENDING_S)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
