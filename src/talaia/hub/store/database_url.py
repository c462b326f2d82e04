"""From the URL a person writes to the one a driver takes; one place for all engines.

The accounts wait in an event loop and the history in threads, so each engine has two drivers.
A URL may name its own driver; it is replaced by the one that fits.
"""

from __future__ import annotations

import ssl
from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import make_url
from sqlalchemy.exc import ArgumentError

from talaia.hub.errors import StoreError

if TYPE_CHECKING:
    from sqlalchemy import URL

__all__ = ["Reach", "reach"]

# How long a server may take to let us in (s). pg8000's would bound every statement as well.
_WITHIN: dict[str, dict[str, Any]] = {
    "postgresql+asyncpg": {"timeout": 5},
    "mysql+aiomysql": {"connect_timeout": 5},
    "mysql+pymysql": {"connect_timeout": 5},
}


class _Engine(NamedTuple):
    """The two drivers of an engine, and the extra that brings them."""

    waiting: str
    blocking: str
    extra: str


_SQLITE = _Engine("sqlite+aiosqlite", "sqlite", "hub")
_POSTGRESQL = _Engine("postgresql+asyncpg", "postgresql+pg8000", "postgresql")
# One name for both brands, so that each statement is written the same for both.
_MARIADB = _Engine("mysql+aiomysql", "mysql+pymysql", "mariadb")
_ENGINES = {
    "sqlite": _SQLITE,
    "postgresql": _POSTGRESQL,
    "postgres": _POSTGRESQL,
    "mysql": _MARIADB,
    "mariadb": _MARIADB,
}
_EXAMPLE = (
    "write it like postgresql://talaia@db.example/talaia, mariadb://talaia@db.example/talaia"
    " or sqlite:////path/talaia.db"
)
# How a driver is told what libpq's sslmode says.
_TLS_KEY = {"postgresql+asyncpg": "ssl", "postgresql+pg8000": "ssl_context"}


class Reach(NamedTuple):
    """How an engine is reached: its URL, the driver's further arguments, the extra it needs."""

    url: URL
    arguments: dict[str, Any]
    extra: str

    def missing(self, error: ImportError) -> StoreError:
        """Say which driver is not installed, and how to get it."""
        name = error.name or str(error)
        return StoreError(
            f"{self.url.get_backend_name()} needs {name}, which is not installed",
            f"pip install 'talaia[{self.extra}]'",
        )


def reach(text: str, *, blocking: bool = False) -> Reach:
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
    engine = _ENGINES.get(url.drivername.partition("+")[0])
    if engine is None:
        raise StoreError(f"there is no engine for {url.drivername!r}", _EXAMPLE)
    url = url.set(drivername=engine.blocking if blocking else engine.waiting)
    if engine is _SQLITE:
        return Reach(url, {}, engine.extra)
    if not url.database:
        raise StoreError("the database URL names no database", _EXAMPLE)
    arguments = dict(_WITHIN.get(url.drivername, {}))
    context = _tls(url)
    if context is not None:
        arguments[_TLS_KEY.get(url.drivername, "ssl")] = context
    url = url.difference_update_query(["sslmode", "sslrootcert"])
    if engine is _MARIADB and "charset" not in url.query:
        url = url.update_query_dict({"charset": "utf8mb4"})
    return Reach(url, arguments, engine.extra)


def _tls(url: URL) -> ssl.SSLContext | None:
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
    context.check_hostname = mode == "verify-full"
    if mode == "require":
        context.verify_mode = ssl.CERT_NONE
    return context
