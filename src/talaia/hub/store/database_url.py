"""From the URL a person writes to the one a driver takes.

The accounts wait in an event loop and the history in threads, so each engine has two drivers.
A URL may name its own driver; it is replaced by the one that fits.
"""

from __future__ import annotations

import ssl
from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import make_url
from sqlalchemy.exc import ArgumentError

from talaia.hub.errors import StoreError
from talaia.hub.store.dialects.choice import MARIADB, find_dialect

if TYPE_CHECKING:
    from collections.abc import Callable

    from sqlalchemy import URL
    from sqlalchemy.engine.interfaces import DBAPIConnection

    from talaia.hub.store.dialects.dialect import Dialect

    # Is given each new connection, before anything else uses it; raises to refuse it.
    OnConnect = Callable[[DBAPIConnection, object], None]

__all__ = ["OnConnect", "Reach", "parse_database_url", "say_at_connect"]

_EXAMPLE = (
    "write it like postgresql://talaia@db.example/talaia, mariadb://talaia@db.example/talaia"
    " or sqlite:////path/talaia.db"
)


def say_at_connect(words: str) -> OnConnect:
    """Give a listener for ``connect`` that says ``words`` to the server; none of no words."""

    def say_words(connection: DBAPIConnection, _record: object) -> None:
        if not words:
            return
        cursor = connection.cursor()
        try:
            cursor.execute(words)
        finally:
            cursor.close()
        # What is set within a transaction would be undone with it.
        connection.commit()

    return say_words


class Reach(NamedTuple):
    """How an engine is reached: its URL, and the driver's further arguments."""

    url: URL
    arguments: dict[str, Any]
    dialect: Dialect

    def missing_driver(self, error: ImportError) -> StoreError:
        """Say which driver is not installed, and how to get it."""
        name = error.name or str(error)
        return StoreError(
            f"{self.url.get_backend_name()} needs {name}, which is not installed",
            f"pip install 'talaia[{self.dialect.extra}]'",
        )


def parse_database_url(text: str, *, blocking: bool = False) -> Reach:
    """Read a database's URL; ``blocking`` takes the driver for threads.

    ``sslmode`` (``disable``, ``require``, ``verify-ca`` or ``verify-full``) and ``sslrootcert``
    (a file) are understood for every server.

    Raises:
        StoreError: it is no URL of an engine that can be used.

    """
    try:
        url = make_url(text)
    except ArgumentError as error:
        raise StoreError("the database URL cannot be read", _EXAMPLE) from error
    dialect = find_dialect(url.drivername.partition("+")[0])
    if dialect is None:
        raise StoreError(f"there is no engine for {url.drivername!r}", _EXAMPLE)
    url = url.set(drivername=dialect.blocking if blocking else dialect.waiting)
    arguments = dict(dialect.connect_arguments(url.drivername))
    if not dialect.is_server:
        return Reach(url, arguments, dialect)
    if not url.database:
        raise StoreError("the database URL names no database", _EXAMPLE)
    context = _tls_context(url)
    if context is not None:
        arguments[dialect.tls_argument(url.drivername)] = context
    elif url.query.get("sslmode") == "disable":
        arguments.update(dialect.plain_arguments(url.drivername))
    # The drivers know these two words in other ways, or not at all.
    url = url.difference_update_query(["sslmode", "sslrootcert"])
    if dialect is MARIADB and "charset" not in url.query:
        # Its older `utf8` holds no character of four bytes.
        url = url.update_query_dict({"charset": "utf8mb4"})
    return Reach(url, arguments, dialect)


def _tls_context(url: URL) -> ssl.SSLContext | None:
    mode, root = url.query.get("sslmode", ""), url.query.get("sslrootcert", "")
    if mode in {"", "disable"}:
        return None
    if mode not in {"require", "verify-ca", "verify-full"} or not isinstance(root, str):
        raise StoreError(
            f"the database URL asks for sslmode={mode}",
            "use disable, require, verify-ca or verify-full",
        )
    try:
        context = ssl.create_default_context(cafile=root or None)
    except OSError as error:
        raise StoreError(f"{root} cannot be read: {error}", "correct sslrootcert") from error
    # `verify-ca` trusts whoever has a certificate of that authority, whatever its name.
    context.check_hostname = mode == "verify-full"
    # Encrypted, but nobody proves who they are. After the line above: Python refuses this while
    # names are checked.
    if mode == "require":
        context.verify_mode = ssl.CERT_NONE
    return context
