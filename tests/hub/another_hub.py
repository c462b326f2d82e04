"""Another hub before one that runs: what comes to it goes to the one that leads, as in a cluster.

Both ends are the product's own; between them stands no NATS, which others test.
"""

# ruff: noqa: D107
from __future__ import annotations

import asyncio
import socket

from talaia.hub.cluster.answering import Answering
from talaia.hub.cluster.entrance import Entrance
from talaia.hub.cluster.tunnel import TunnelName
from talaia.hub.run import server_of

LEAD, BETWEEN = "lead", "between"


class AnotherHub:
    """A hub that waits, at a port of its own, before a hub of this process that leads."""

    setup_token = None
    judging = True

    def __init__(self, lead) -> None:
        self.settings = lead.settings
        self._answering = Answering(self._post_down)
        self._answering.begin_answering(lead.asgi)
        self._entrance = Entrance(find_lead=lambda: LEAD, post=self._post_up)

    @property
    def asgi(self):
        return self

    async def __aenter__(self) -> AnotherHub:
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.port = self._listener.getsockname()[1]
        self.origin = f"http://127.0.0.1:{self.port}"
        ready = asyncio.Event()
        self._server = server_of(self, ready.set)
        self._serving = asyncio.create_task(self._server.serve(sockets=[self._listener]))
        await ready.wait()
        return self

    async def __aexit__(self, *_exc: object) -> None:
        self._server.should_exit = True
        await self._serving
        self._listener.close()
        await self._answering.finish_answering("it ends")

    def is_driven(self) -> bool:
        return False

    def cached_bytes(self) -> int:
        return 0

    async def hand_over(self) -> None: ...

    async def __call__(self, scope, receive, send) -> None:
        if scope["type"] != "lifespan":
            await self._entrance.serve_request(scope, receive, send)
            return
        await receive()
        await send({"type": "lifespan.startup.complete"})
        await receive()
        await send({"type": "lifespan.shutdown.complete"})

    async def _post_up(self, name, lane, frame) -> None:
        self._answering.receive_frame(TunnelName(BETWEEN, name.number), lane, frame)

    async def _post_down(self, name, _lane, frame) -> None:
        self._entrance.receive_frame(TunnelName(LEAD, name.number), frame)
