"""The way to a database server, which may stand still: it takes what comes, and gives no answer."""

from __future__ import annotations

import asyncio
from contextlib import suppress

import sqlalchemy as sa


class FrozenWay:
    """A port that leads to a server; while `frozen`, bytes wait, and go on later."""

    def __init__(self, url: str) -> None:  # noqa: D107
        self._target = sa.make_url(url)
        self._moves = asyncio.Event()
        self._moves.set()
        self._writers: list[asyncio.StreamWriter] = []
        self._tasks: set[asyncio.Task] = set()

    @property
    def url(self) -> str:
        """The server's URL by this way."""
        return self._target.set(host="127.0.0.1", port=self.port).render_as_string(
            hide_password=False
        )

    def freeze(self) -> None:
        self._moves.clear()

    def thaw(self) -> None:
        self._moves.set()

    async def __aenter__(self) -> FrozenWay:
        self._server = await asyncio.start_server(self._lead, "127.0.0.1", 0)
        self.port = self._server.sockets[0].getsockname()[1]
        return self

    async def __aexit__(self, *_exc: object) -> None:
        self.thaw()
        self._server.close()
        for task in self._tasks:
            task.cancel()
        for writer in self._writers:
            writer.transport.abort()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    async def _lead(self, near_in, near_out) -> None:
        port = self._target.port or {"postgresql": 5432}.get(self._target.get_backend_name(), 3306)
        far_in, far_out = await asyncio.open_connection(self._target.host, port)
        self._writers += [near_out, far_out]
        for source, target in ((near_in, far_out), (far_in, near_out)):
            task = asyncio.create_task(self._pour(source, target))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

    async def _pour(self, source, target) -> None:
        with suppress(OSError):
            while data := await source.read(65536):
                await self._moves.wait()
                target.write(data)
                await target.drain()
        target.close()
