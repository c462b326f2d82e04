"""What the hub asks of each engine in its own words; everything else is SQLAlchemy's to say."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from contextlib import AbstractContextManager
    from pathlib import Path

    from numpy.typing import NDArray
    from sqlalchemy import URL, Connection, Engine, Select, Table
    from sqlalchemy.engine.interfaces import DBAPIConnection
    from sqlalchemy.sql.selectable import CompoundSelect

    from talaia.hub.store.dialects.lead_words import LeadWords

    # A column's values, in the order of the rows.
    Values = Sequence[Any] | NDArray[Any]
    Query = Select[Any] | CompoundSelect[Any]

__all__ = ["SINGLE", "WRITES", "Dialect", "Row"]

Row = dict[str, Any]
# The execution option of a connection whose transactions write.
WRITES = "talaia_writes"
# The one of a connection that runs a single query, which needs no transaction around it.
SINGLE = "talaia_single"


class Dialect(Protocol):
    """One engine; without state.

    Attributes:
        waiting: the driver for the event loop, as SQLAlchemy names it.
        blocking: the driver for threads.
        extra: the extra of our package that brings them.
        is_server: it is reached over a network, and its disk is not ours.
        has_checkpoints: somebody has to keep its journal short.
        remedy: what to do when it cannot be opened.
        lead: how it says which of several hubs leads; none: only one hub can use it.
        opening_bounds: the blocking driver's arguments by which a server that lets nobody in is
            not waited for; `prepare_history` lifts them from a connection that is open.
        idle_bound: ends the session of a hub that stands still within a transaction, which would
            keep every other one from writing; empty: there is no such session.

    """

    waiting: str
    blocking: str
    extra: str
    is_server: bool
    has_checkpoints: bool
    remedy: str
    lead: LeadWords | None
    opening_bounds: Mapping[str, int]
    idle_bound: str

    # ── connections ──

    def connect_arguments(self, driver: str) -> Mapping[str, Any]:
        """Give a driver's further arguments; a server lets us in within seconds or not at all."""
        ...

    def tls_argument(self, driver: str) -> str:
        """Name the argument by which a driver takes an `ssl.SSLContext`."""
        ...

    def plain_arguments(self, driver: str) -> Mapping[str, Any]:
        """Give what makes a driver speak without TLS, which some try where nothing is said."""
        ...

    def prepare_accounts(self, engine: Engine) -> None:
        """Prepare the connections for accounts; those with the option `WRITES` write.

        Those with `SINGLE` begin no transaction where the engine does not do so by itself.
        """
        ...

    async def wait_closed(self, engine: Engine) -> None:
        """Wait until nothing of the connections for accounts runs any more; they are closed."""
        ...

    def prepare_history(self, engine: Engine, *, writes: bool) -> None:
        """Prepare the connections for the history, which write or only read."""
        ...

    def open_snapshot(self, engine: Engine) -> Engine:
        """Give an engine whose transactions see one state, however long they take."""
        ...

    def cut_connection(self, connection: DBAPIConnection) -> None:
        """End a connection under a thread that waits for its answer; that fails at once."""
        ...

    def driver_errors(self, engine: Engine) -> tuple[type[Exception], ...]:
        """Give errors of a driver that SQLAlchemy does not translate."""
        ...

    # ── taking turns ──

    def await_write_turn(self, connection: Connection) -> None:
        """Wait until no other transaction writes accounts; ours holds the turn to its end."""
        ...

    def hold_migrations(self, connection: Connection) -> AbstractContextManager[None]:
        """Keep other programs from changing tables meanwhile.

        Raises:
            StoreDown: another one does so, and does not end.

        """
        ...

    # ── many rows ──

    def write_rows(
        self,
        connection: Connection,
        table: Table,
        names: tuple[str, ...],
        rows: Sequence[Sequence[Any]],
        *,
        in_place: bool,
    ) -> None:
        """Insert rows of values of the columns ``names``; ``in_place`` of the same primary key's.

        A statement for each row would be most of the time on a server: every one waits for an
        answer. And these few statements run a thousand times a second, so their words are made
        once.
        """
        ...

    def run_statements(self, connection: Connection, statements: Sequence[str]) -> None:
        """Run statements without parameters in their order, with as few answers to wait for."""
        ...

    def fetch_columns(
        self, connection: Connection, query: Query, parameters: Mapping[str, int]
    ) -> Iterator[Values]:
        """Run a query whose columns are times (µs) and values in turn, and give each column.

        A query is made once, and run with other ``parameters`` each time. A column holds numbers,
        or None for NULL. There is no column when there is no row.
        """
        ...

    def advance_sequences(self, connection: Connection, table: Table) -> None:
        """Number new rows behind those that were copied into a table with their numbers."""
        ...

    # ── words ──

    def time_of(self, microseconds: str) -> str:
        """Write the SQL for a time as people read it, of SQL for microseconds since the epoch."""
        ...

    def store_uncompressed(self, connection: Connection, table: Table) -> None:
        """Keep the engine from compressing a new table's column ``body`` once more."""
        ...

    # ── what it takes ──

    def product_name(self, connection: Connection) -> str:
        """Name the product."""
        ...

    def measure_size(self, connection: Connection) -> tuple[int, int]:
        """Give what the database takes, and what more is free inside of it (bytes)."""
        ...

    def file_of(self, url: URL) -> Path | None:
        """Give the file that holds the database; none for a server's."""
        ...
