"""Whether a server of histories answers: asked over a connection of its own, beside all work."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

from sqlalchemy import select
from sqlalchemy.exc import SQLAlchemyError

from talaia.hub.history.connection_cut import ConnectionCut
from talaia.hub.history.engine import open_engine

if TYPE_CHECKING:
    from sqlalchemy import Engine

__all__ = ["ServerPulse"]


class ServerPulse:
    """Asks one server for next to nothing, again and again."""

    def __init__(self, url: str, patience_s: float) -> None:
        """Ask at ``url``; without an answer for ``patience_s`` it stands still."""
        self._url, self._patience_s = url, patience_s
        self._cut = ConnectionCut()
        self._engine: Engine | None = None
        self._thread = ThreadPoolExecutor(1, "history-pulse")

    async def beats(self) -> bool:
        """Tell whether it answers in time; one that refuses or is gone does answer."""
        loop = asyncio.get_running_loop()
        try:
            async with asyncio.timeout(self._patience_s):
                await loop.run_in_executor(self._thread, self._ask)
        except TimeoutError:
            return False
        except (SQLAlchemyError, OSError):
            # What is asked of it fails by itself, and says why.
            return True
        return True

    def end(self) -> None:
        """Ask nothing more; does not block."""
        self._cut.cut_all()
        self._thread.submit(self._dispose)
        self._thread.shutdown(wait=False)

    def _ask(self) -> None:
        if self._engine is None:
            self._engine = open_engine(self._url, writes=True, cut=self._cut)
        with self._engine.connect() as connection:
            connection.execute(select(1))

    def _dispose(self) -> None:
        if self._engine is not None:
            self._engine.dispose()
