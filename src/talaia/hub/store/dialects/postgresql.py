"""PostgreSQL, by asyncpg for accounts and by pg8000 for the history."""

from __future__ import annotations

import contextlib
import socket
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any

from sqlalchemy import String, Text, cast, event, func, select, text

from talaia.hub.store.dialects.lead_words import POSTGRESQL_LEAD
from talaia.hub.store.dialects.socket_end import shut_socket
from talaia.hub.store.dialects.statement_words import insert_head, on_conflict, parse_columns

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from sqlalchemy import URL, Connection, Engine, Select, Table, TextClause
    from sqlalchemy.engine.interfaces import DBAPIConnection
    from sqlalchemy.pool import ConnectionPoolEntry

    from talaia.hub.store.dialects.dialect import Query, Values
    from talaia.hub.store.dialects.lead_words import LeadWords

__all__ = ["PostgresqlDialect"]

# Locks have numbers: "tala", for ours.
_LOCK = 0x74616C61
# A server may take so long to let us in (s). pg8000's option would bound every statement as well.
_CONNECT_S = 5
# Queries of columns that are kept with what gathers them.
_QUERIES = 64


class PostgresqlDialect:
    """See `Dialect`."""

    waiting = "postgresql+asyncpg"
    blocking = "postgresql+pg8000"
    extra = "postgresql"
    is_server = True
    has_checkpoints = False
    remedy = "check that the server runs, and that the database and its user are there"
    lead: LeadWords | None = POSTGRESQL_LEAD
    opening_bounds: Mapping[str, int] = {"timeout": _CONNECT_S}
    idle_bound = "SET idle_in_transaction_session_timeout = '10s'"

    def connect_arguments(self, driver: str) -> Mapping[str, Any]:
        """Bound the time it takes to be let in, where the driver can."""
        return {"timeout": _CONNECT_S} if driver == self.waiting else {}

    def tls_argument(self, driver: str) -> str:
        """Name it."""
        return "ssl" if driver == self.waiting else "ssl_context"

    def plain_arguments(self, driver: str) -> Mapping[str, Any]:
        """Keep both drivers from trying."""
        return {self.tls_argument(driver): False}

    def prepare_accounts(self, engine: Engine) -> None:
        """Do nothing: asyncpg needs no help."""

    async def wait_closed(self, engine: Engine) -> None:
        """Do nothing: closing waits for the server's answer."""
        del engine

    def prepare_history(self, engine: Engine, *, writes: bool) -> None:
        """Save pg8000 most of its waiting."""
        del writes
        event.listen(engine, "connect", _send_at_once)
        event.listen(engine, "connect", _wait_for_answers)
        event.listen(engine, "before_cursor_execute", _inline_integers, retval=True, named=True)

    def open_snapshot(self, engine: Engine) -> Engine:
        """Take the level at which a transaction sees the state of its first statement."""
        return engine.execution_options(isolation_level="REPEATABLE READ")

    def cut_connection(self, connection: DBAPIConnection) -> None:
        """Shut pg8000's socket."""
        opened = getattr(connection, "_usock", None)
        shut_socket(opened)
        if isinstance(opened, socket.socket):
            # Its own farewell would go to a socket that is shut, and fail, and be logged.
            connection.close = opened.close  # type: ignore[method-assign]

    def driver_errors(self, engine: Engine) -> tuple[type[Exception], ...]:
        """Give asyncpg's own: they come through unchanged while a connection is made."""
        driver = getattr(engine.dialect.dbapi, "asyncpg", None)
        return () if driver is None else (driver.PostgresError, driver.InterfaceError)

    def await_write_turn(self, connection: Connection) -> None:
        """Take a lock that ends with the transaction."""
        connection.execute(select(func.pg_advisory_xact_lock(_LOCK)))

    @contextlib.contextmanager
    def hold_migrations(self, connection: Connection) -> Iterator[None]:
        """Take the turn to write: changes of tables are part of the transaction."""
        self.await_write_turn(connection)
        yield

    def write_rows(
        self,
        connection: Connection,
        table: Table,
        names: tuple[str, ...],
        rows: Sequence[Sequence[Any]],
        *,
        in_place: bool,
    ) -> None:
        """Write numbers and bytes into the statement, texts as arrays.

        With parameters pg8000 would look through the words for their places, character by
        character, and wait twice for an answer. Texts would have to be quoted, which is the
        driver's to do: they go as one array for each column.
        """
        if _has_texts(table, names):
            columns = map(list, zip(*rows, strict=True))
            found = dict(zip(names, columns, strict=True))
            connection.execute(_unnest_insert(table, names, in_place), found)
            return
        past = on_conflict(table, names) if in_place else ""
        written = ",".join([f"({','.join(map(_sql_literal, row))})" for row in rows])
        connection.exec_driver_sql(f"{insert_head(table, names)}{written}{past}")

    def run_statements(self, connection: Connection, statements: Sequence[str]) -> None:
        """Send all at once: what has no parameters may be several statements."""
        connection.exec_driver_sql("; ".join(statements))

    def fetch_columns(
        self, connection: Connection, query: Query, parameters: Mapping[str, int]
    ) -> Iterator[Values]:
        """Ask for one long text of each column: pg8000 is Python, and ten times slower by rows."""
        found = connection.execute(_gathered(query), parameters).one()
        if found[0] is None:
            return iter(())
        return parse_columns(found)

    def advance_sequences(self, connection: Connection, table: Table) -> None:
        """Set the sequence of a table that has one: rows with numbers leave it where it was."""
        column = table.autoincrement_column
        if column is None:
            return
        sequence = connection.scalar(select(func.pg_get_serial_sequence(table.name, column.name)))
        newest = connection.scalar(select(func.max(column)))
        if sequence is not None and newest is not None:
            connection.execute(select(func.setval(sequence, newest)))

    def time_of(self, microseconds: str) -> str:
        """Write a time with its zone, which clients show in theirs."""
        return f"to_timestamp({microseconds} / 1000000.0)"

    def store_uncompressed(self, connection: Connection, table: Table) -> None:
        """Let bodies be: they are compressed already, and to try again costs as much."""
        connection.exec_driver_sql(
            f"ALTER TABLE {table.name} ALTER COLUMN body SET STORAGE EXTERNAL"
        )

    def product_name(self, connection: Connection) -> str:
        """Name it."""
        del connection
        return "PostgreSQL"

    def measure_size(self, connection: Connection) -> tuple[int, int]:
        """Ask the server; it does not tell what is free inside."""
        found = connection.exec_driver_sql("SELECT pg_database_size(current_database())")
        return int(found.scalar() or 0), 0

    def file_of(self, url: URL) -> Path | None:
        """Give none."""
        del url
        return None


def _send_at_once(connection: DBAPIConnection, _entry: ConnectionPoolEntry) -> None:
    """Let pg8000's socket hold nothing back.

    It would keep the end of a long statement until the server has acknowledged the beginning,
    for which the server takes 40 ms.
    """
    # The driver has no option for it. Without its socket it is slow, nothing else.
    opened = getattr(connection, "_usock", None)
    if isinstance(opened, socket.socket) and opened.family != socket.AF_UNIX:
        opened.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)


def _wait_for_answers(connection: DBAPIConnection, _entry: ConnectionPoolEntry) -> None:
    """Let an answer take as long as it takes; pg8000 bounds all by what bounds being let in."""
    opened = getattr(connection, "_usock", None)
    if isinstance(opened, socket.socket):
        opened.settimeout(None)


def _inline_integers(
    *,
    statement: str,
    parameters: Any,  # noqa: ANN401 - whatever the dialect makes of them
    executemany: bool,
    **_others: object,
) -> tuple[str, Any]:
    """Write whole numbers into the statement itself.

    For a parameter pg8000 looks through the statement character by character, and asks the server
    twice and waits twice; times and block numbers are most of what we ever ask by.
    """
    if executemany or not parameters or not all(type(value) is int for value in parameters):
        return statement, parameters
    return statement % tuple(f"'{value}'" for value in parameters), ()


def _sql_literal(value: float | bytes | None) -> str:
    """Write a value so that PostgreSQL reads the same one."""
    if value is None:
        return "NULL"
    if isinstance(value, bytes):
        return f"decode('{value.hex()}','hex')"
    if not isinstance(value, float | int):
        raise TypeError(f"only numbers and bytes stand in a statement, no {type(value).__name__}")
    # Quoted, a float is read as a double at once; Python's digits give back every bit.
    return f"'{value!r}'"


@lru_cache(_QUERIES)
def _gathered(query: Query) -> Select[Any]:
    columns = query.subquery().c
    return select(
        *(func.string_agg(func.coalesce(cast(column, Text), "nan"), ",") for column in columns)
    )


@cache
def _has_texts(table: Table, names: tuple[str, ...]) -> bool:
    return any(isinstance(table.c[name].type, String) for name in names)


@cache
def _unnest_insert(table: Table, names: tuple[str, ...], in_place: bool) -> TextClause:  # noqa: FBT001
    arrays = ", ".join(f"CAST(:{name} AS {_array_type(table, name)})" for name in names)
    head = insert_head(table, names).removesuffix("VALUES ")
    past = on_conflict(table, names) if in_place else ""
    return text(f"{head}SELECT * FROM unnest({arrays}){past}")  # noqa: S608


def _array_type(table: Table, name: str) -> str:
    kind = table.c[name].type
    if isinstance(kind, String):
        return "text[]"
    return "double precision[]" if kind.python_type is float else "bigint[]"
