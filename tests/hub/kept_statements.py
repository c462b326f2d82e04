"""What SQLAlchemy makes of a statement, made once for all databases of one kind in a process.

Each hub has an engine of its own, which would write the same statements as SQL again: a good part
of what it takes to start a hub, and of the first answer to each request.
"""

from __future__ import annotations

import functools

import pytest
from sqlalchemy import Connection, Engine, event
from sqlalchemy.util import LRUCache

# So many statements of one kind of database; each takes some 10 kB.
_MOST = 1000


class _KeptStatements:
    """What `Connection` asks for statements; their keys begin with the dialect of one engine."""

    def __init__(self) -> None:
        self._kept = LRUCache(_MOST)

    def get(self, key):
        return self._kept.get(key[1:])

    def __setitem__(self, key, compiled) -> None:
        self._kept[key[1:]] = compiled


@functools.cache
def _statements_of(*_kind_of_database: object) -> _KeptStatements:
    return _KeptStatements()


def _share(connection: Connection) -> None:
    dialect = connection.dialect
    # Two servers of one name may write differently by their version.
    kept = _statements_of(dialect.name, dialect.driver, dialect.server_version_info)
    connection.execution_options(compiled_cache=kept)


@pytest.fixture(scope="session", autouse=True)
def _statements_are_written_once():
    """Spare a fifth of what it takes to start a hub and to answer for the first time."""
    event.listen(Engine, "engine_connect", _share)
    yield
    event.remove(Engine, "engine_connect", _share)
