"""Connections that another thread can end: nobody waits for a server that stands still."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING
from weakref import WeakSet

from sqlalchemy import event
from sqlalchemy.exc import OperationalError

from talaia.hub.store.dialects.choice import dialect_of

if TYPE_CHECKING:
    from sqlalchemy import Engine
    from sqlalchemy.engine.interfaces import DBAPIConnection

    from talaia.hub.store.dialects.dialect import Dialect

__all__ = ["ConnectionCut"]


class ConnectionCut:
    """Ends all connections of some engines, for good; what waits for an answer fails at once."""

    def __init__(self) -> None:
        """Cut nothing yet."""
        self._lock = threading.Lock()
        self._dialects: list[Dialect] = []
        # Those of threads that may wait just now.
        self._connections: WeakSet[DBAPIConnection] = WeakSet()
        self._is_cut = False

    def guard_engine(self, engine: Engine) -> None:
        """Follow the connections of an engine."""
        # A file answers, or fails by itself.
        if not dialect_of(engine).is_server:
            return
        self._dialects.append(dialect_of(engine))
        event.listen(engine, "do_connect", self._refuse_cut)
        event.listen(engine, "connect", self._follow)

    def cut_all(self) -> None:
        """End every connection, and let no other be made; from any thread."""
        with self._lock:
            self._is_cut = True
            connections = list(self._connections)
        for connection in connections:
            self._cut(connection)

    def _refuse_cut(self, *_arguments: object) -> None:
        if self._is_cut:
            raise OperationalError("connect", None, ConnectionError("it stood still"))

    def _follow(self, connection: DBAPIConnection, _record: object) -> None:
        with self._lock:
            self._connections.add(connection)
            late = self._is_cut
        # It was being made meanwhile.
        if late:
            self._cut(connection)

    def _cut(self, connection: DBAPIConnection) -> None:
        # All engines of one store are of one kind.
        self._dialects[0].cut_connection(connection)
