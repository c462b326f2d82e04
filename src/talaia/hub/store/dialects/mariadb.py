"""MariaDB and MySQL, by aiomysql for accounts and by PyMySQL for the history.

SQLAlchemy is told "mysql" for both brands, so that each statement is written the same for both.
"""

from __future__ import annotations

import contextlib
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any

from sqlalchemy import case, event, func, or_, select, text

from talaia.hub.errors import StoreDown
from talaia.hub.store.dialects.lead_words import MARIADB_LEAD
from talaia.hub.store.dialects.socket_end import shut_socket
from talaia.hub.store.dialects.statement_words import (
    insert_head,
    parse_columns,
    run_for_rows,
    split_names,
)
from talaia.hub.store.tables import write_turn

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from sqlalchemy import URL, Connection, Engine, Select, Table
    from sqlalchemy.engine.interfaces import DBAPIConnection
    from sqlalchemy.pool import ConnectionPoolEntry

    from talaia.hub.store.dialects.dialect import Query, Values
    from talaia.hub.store.dialects.lead_words import LeadWords

__all__ = ["MariadbDialect"]

# A server may take so long to let us in (s).
_CONNECT_S = 5
# Queries of columns that are kept with what gathers them.
_QUERIES = 64
# A lock's name is the whole server's, so the database's name is in it.
_LOCK_NAME = "talaia migrations in "
# So long a program waits for another one that changes the tables (s).
_MIGRATE_S = 120


class MariadbDialect:
    """See `Dialect`."""

    waiting = "mysql+aiomysql"
    blocking = "mysql+pymysql"
    extra = "mariadb"
    is_server = True
    has_checkpoints = False
    remedy = "check that the server runs, and that the database and its user are there"
    lead: LeadWords | None = MARIADB_LEAD
    # MySQL has no such bound, and passes over what is for MariaDB alone.
    opening_bounds: Mapping[str, int] = {"read_timeout": _CONNECT_S}
    idle_bound = "SET @talaia = 1 /*M!100300 , SESSION idle_transaction_timeout = 10 */"

    def connect_arguments(self, driver: str) -> Mapping[str, Any]:
        """Bound the time it takes to be let in."""
        del driver
        return {"connect_timeout": _CONNECT_S}

    def tls_argument(self, driver: str) -> str:
        """Name it."""
        del driver
        return "ssl"

    def plain_arguments(self, driver: str) -> Mapping[str, Any]:
        """Keep PyMySQL from trying; aiomysql encrypts only when it is told to."""
        return {"ssl_disabled": True} if driver == self.blocking else {}

    def prepare_accounts(self, engine: Engine) -> None:
        """Mend what aiomysql has lost."""
        event.listen(engine, "connect", _let_bytes_pass)

    async def wait_closed(self, engine: Engine) -> None:
        """Do nothing: closing waits for the server's answer."""
        del engine

    def prepare_history(self, engine: Engine, *, writes: bool) -> None:
        """Allow the long texts that `fetch_columns` asks for."""
        del writes
        event.listen(engine, "connect", _gather_long)
        event.listen(engine, "connect", _wait_for_answers)

    def open_snapshot(self, engine: Engine) -> Engine:
        """Take the level at which a transaction sees the state of its first statement."""
        return engine.execution_options(isolation_level="REPEATABLE READ")

    def cut_connection(self, connection: DBAPIConnection) -> None:
        """Shut PyMySQL's socket."""
        shut_socket(getattr(connection, "_sock", None))

    def driver_errors(self, engine: Engine) -> tuple[type[Exception], ...]:
        """Give none: all are translated."""
        del engine
        return ()

    def await_write_turn(self, connection: Connection) -> None:
        """Lock the one row of a table that is there for this; it ends with the transaction."""
        # Whoever has the one row of this table has the turn, until the transaction ends.
        connection.execute(select(write_turn.c.id).with_for_update())

    @contextlib.contextmanager
    def hold_migrations(self, connection: Connection) -> Iterator[None]:
        """Take a lock by name: row locks end with the first change of a table, this one lasts."""
        name = {"name": _LOCK_NAME + (connection.engine.url.database or "")}
        # No row lock: each change of tables ends the transaction there, and the lock with it.
        words = text("SELECT GET_LOCK(:name, :wait)")
        if connection.execute(words, {**name, "wait": _MIGRATE_S}).scalar() != 1:
            raise StoreDown("another program is changing the tables", "try again soon")
        try:
            yield
            # A change of a table commits what was before it, the last step's number not: whoever
            # gets the lock next would read the number before, and do that step again.
            connection.exec_driver_sql("COMMIT")
        finally:
            connection.execute(text("SELECT RELEASE_LOCK(:name)"), name)

    def write_rows(
        self,
        connection: Connection,
        table: Table,
        names: tuple[str, ...],
        rows: Sequence[Sequence[Any]],
        *,
        in_place: bool,
    ) -> None:
        """Let the driver make one statement of all rows."""
        run_for_rows(connection, _insert_words(table, names, in_place), rows)

    def run_statements(self, connection: Connection, statements: Sequence[str]) -> None:
        """Make one compound statement of them, which MySQL knows in stored programs alone."""
        if getattr(connection.dialect, "is_mariadb", False):
            connection.exec_driver_sql(f"BEGIN NOT ATOMIC {'; '.join(statements)}; END")
            return
        for words in statements:
            connection.exec_driver_sql(words)

    def fetch_columns(
        self, connection: Connection, query: Query, parameters: Mapping[str, int]
    ) -> Iterator[Values]:
        """Ask for one long text of each column: PyMySQL is Python, ten times slower by rows.

        MariaDB shortens a number that it turns into a text before it is gathered, so NULL cannot
        become a word there; buckets of nothing but NaN are rare enough to ask again for all.
        """
        *found, empty = connection.execute(_gathered(query), parameters).one()
        if empty:
            return iter(zip(*connection.execute(query, parameters).all(), strict=True))
        if found[0] is None:
            return iter(())
        return parse_columns(found)

    def advance_sequences(self, connection: Connection, table: Table) -> None:
        """Do nothing: the next number is one past the greatest that is there."""
        del connection, table

    def time_of(self, microseconds: str) -> str:
        """Write a time in UTC: a TIMESTAMP would end in 2038."""
        return f"TIMESTAMPADD(MICROSECOND, {microseconds}, '1970-01-01 00:00:00.000000')"

    def store_uncompressed(self, connection: Connection, table: Table) -> None:
        """Do nothing: it compresses nothing unless it is told to."""
        del connection, table

    def product_name(self, connection: Connection) -> str:
        """Name the brand that answers."""
        return "MariaDB" if getattr(connection.dialect, "is_mariadb", False) else "MySQL"

    def measure_size(self, connection: Connection) -> tuple[int, int]:
        """Sum up the tables; what is free inside is the server's own matter."""
        found = connection.exec_driver_sql(
            "SELECT SUM(data_length + index_length) FROM information_schema.tables"
            " WHERE table_schema = DATABASE()"
        )
        return int(found.scalar() or 0), 0

    def file_of(self, url: URL) -> Path | None:
        """Give none."""
        del url
        return None


@cache
def _insert_words(table: Table, names: tuple[str, ...], in_place: bool) -> str:  # noqa: FBT001
    past = ""
    if in_place:
        _, others = split_names(table, names)
        changes = ", ".join(f"{name} = VALUES({name})" for name in others)
        past = f" ON DUPLICATE KEY UPDATE {changes}"
    return f"{insert_head(table, names)}({', '.join(['%s'] * len(names))}){past}"


@lru_cache(_QUERIES)
def _gathered(query: Query) -> Select[Any]:
    columns = list(query.subquery().c)
    has_null = case((or_(*(column.is_(None) for column in columns[1::2])), 1), else_=0)
    texts = [func.group_concat(func.ifnull(column, 0)) for column in columns]
    return select(*texts, func.sum(has_null))


def _let_bytes_pass(connection: DBAPIConnection, _record: object) -> None:
    """Write bytes as MariaDB reads them: aiomysql 0.3 has lost how.

    It imports from PyMySQL what is not there any more since its 1.2:
    https://github.com/PyMySQL/PyMySQL/issues/1274.
    """
    driver: Any = connection.driver_connection
    escape = driver.escape

    def with_bytes(value: object) -> str:
        said: str = f"_binary X'{value.hex()}'" if isinstance(value, bytes) else escape(value)
        return said

    driver.escape = with_bytes


def _wait_for_answers(connection: DBAPIConnection, _entry: ConnectionPoolEntry) -> None:
    """Let an answer take as long as it takes; until now it was bounded, as being let in is."""
    # PyMySQL sets it anew before each answer.
    if hasattr(connection, "_read_timeout"):
        connection._read_timeout = None  # noqa: SLF001 - it has no option for it


def _gather_long(connection: DBAPIConnection, _entry: ConnectionPoolEntry) -> None:
    """Let MariaDB make one text of many rows; it would cut it off at a megabyte, silently."""
    cursor = connection.cursor()
    # 64 MiB: beyond the limit the server would cut a text off without failing.
    cursor.execute("SET SESSION group_concat_max_len = 67108864")
    cursor.close()
