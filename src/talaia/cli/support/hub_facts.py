"""Texts of a support bundle that are read from a hub: its health, database and gateways."""

from __future__ import annotations

import datetime as dt
import ssl
import time
import urllib.error
import urllib.request
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from sqlalchemy import Connection

__all__ = ["DatabaseFacts", "describe_health", "read_database"]

_HEALTH_S = 5.0


class DatabaseFacts(NamedTuple):
    """What a hub's database says of itself.

    Attributes:
        sizes: its kind, version, form and size, and how many rows each table has.
        gateways: each with site, name, version and when it was seen last.

    """

    sizes: str
    gateways: str


def describe_health(data: Path, port: int) -> str:
    """Ask a hub on this machine whether it answers."""
    context = ssl.create_default_context()
    # Its own certificate names it as people dial it; nothing is told to whoever answers here.
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    rows = []
    # Plain text is served on loopback, or behind a proxy.
    for scheme in ("https", "http"):
        began = time.monotonic()
        address = f"{scheme}://127.0.0.1:{port}/api/health"
        try:
            with urllib.request.urlopen(address, timeout=_HEALTH_S, context=context) as answer:  # noqa: S310 - this machine
                said = answer.read(1000).decode("utf-8", "replace")
                took = (time.monotonic() - began) * 1000
                rows.append(f"{address}: {answer.status} after {took:.0f} ms: {said}")
                break
        except (OSError, urllib.error.URLError) as error:
            rows.append(f"{address}: {getattr(error, 'reason', None) or error}")
    rows.append(f"data folder: {'there' if data.is_dir() else 'not there'}")
    return "\n".join([*rows, ""])


def read_database(url: str) -> DatabaseFacts:
    """Look at a hub's database, which may be in use; nothing that people wrote is read."""
    try:
        from sqlalchemy import make_url
        from sqlalchemy.exc import SQLAlchemyError

        from talaia.errors import TalaiaError
        from talaia.hub.store.dump import open_plain
    except ModuleNotFoundError as error:
        said = f"not read: the package {error.name} is not installed\n"
        return DatabaseFacts(said, said)
    try:
        parsed = make_url(url)
        # To look at one that is not there would make it.
        if parsed.get_backend_name() == "sqlite" and not Path(parsed.database or "").is_file():
            return DatabaseFacts("there is none\n", "there is no database\n")
        engine = open_plain(url)
        try:
            with engine.connect() as connection:
                return DatabaseFacts(_describe_sizes(connection), _describe_gateways(connection))
        finally:
            engine.dispose()
    except (SQLAlchemyError, TalaiaError, OSError) as error:
        said = f"cannot be read: {getattr(error, 'orig', None) or error}\n"
        return DatabaseFacts(said, said)


def _describe_sizes(connection: Connection) -> str:
    from sqlalchemy import func, inspect, select

    from talaia.hub.store.dialects.choice import dialect_of
    from talaia.hub.store.dump import VERSION_TABLE
    from talaia.hub.store.tables import metadata

    dialect = dialect_of(connection)
    total, spare = dialect.measure_size(connection)
    version = ".".join(map(str, (connection.dialect.server_version_info or ())[:3]))
    rows = [
        f"{dialect.product_name(connection)} {version}",
        f"{total:>15,}  bytes, of which free for what comes: {spare:,}",
    ]
    # A database of an earlier form lacks some.
    there = set(inspect(connection).get_table_names())
    if VERSION_TABLE.name in there:
        rows.append(f"form of the tables: {connection.scalar(select(VERSION_TABLE.c.version_num))}")
    for table in metadata.sorted_tables:
        if table.name in there:
            count = connection.scalar(select(func.count()).select_from(table))
            rows.append(f"{count:>15,}  rows of {table.name}")
        else:
            rows.append(f"{'missing':>15}  {table.name}")
    return "\n".join([*rows, ""])


def _describe_gateways(connection: Connection) -> str:
    from sqlalchemy import select

    from talaia.hub.store.tables import gateways

    columns = gateways.c
    query = select(
        columns.site, columns.name, columns.version, columns.seen_us, columns.revoked_us
    ).order_by(columns.site, columns.id)
    rows = []
    for site, name, version, seen_us, revoked_us in connection.execute(query):
        seen = f"seen {_utc_text(seen_us)}" if seen_us else "never seen"
        key = f", its key void since {_utc_text(revoked_us)}" if revoked_us else ""
        rows.append(f"{site}: {name or 'no name'}, Talaia {version or 'not known'}, {seen}{key}")
    return "\n".join([*(rows or ["none"]), ""])


def _utc_text(micros: int) -> str:
    return dt.datetime.fromtimestamp(micros / 1e6, dt.UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
