"""The peer of the history's bench: one table for each sensor, one row for each sample.

It is what the founding designs do: time and value as columns, the time as key, on the same server,
in the same run, with statements of many rows.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np
import sqlalchemy as sa
from sqlalchemy import event

from talaia.hub.history.writing.bulk_writes import insert_rows
from talaia.hub.store.dialects.sqlite import open_sqlite

if TYPE_CHECKING:
    from talaia.wire.columns import Columns

__all__ = ["RowTables", "database_bytes"]


class RowTables:
    """Sensors as tables of rows."""

    def __init__(self, url: str, signals: int) -> None:
        """Make the tables."""
        self.engine = sa.create_engine(url)
        if self.engine.dialect.name == "sqlite":
            event.listen(self.engine, "connect", open_sqlite())
            event.listen(
                self.engine, "begin", lambda connection: connection.exec_driver_sql("BEGIN")
            )
        metadata = sa.MetaData()
        self.tables = [
            sa.Table(
                f"sensor_{at}",
                metadata,
                sa.Column("time_us", sa.BigInteger, primary_key=True, autoincrement=False),
                sa.Column("value", sa.Double),
                sqlite_with_rowid=False,
            )
            for at in range(signals)
        ]
        metadata.create_all(self.engine)

    def store(self, columns: Columns) -> float:
        """Commit a batch; give how long it took (s)."""
        before = time.perf_counter()
        with self.engine.begin() as connection:
            for at in np.unique(columns.channel).tolist():
                mine = columns.channel == at
                times, values = columns.time_us[mine].tolist(), columns.value[mine].tolist()
                rows = [{"time_us": t, "value": v} for t, v in zip(times, values, strict=True)]
                insert_rows(connection, self.tables[at], rows)
        return time.perf_counter() - before

    def chart(self, from_us: int, to_us: int, pixels: int) -> float:
        """Read least and greatest of each pixel of the first sensor; give how long it took (s)."""
        table = self.tables[0]
        pixel = table.c.time_us / max(1, (to_us - from_us) // pixels)
        if self.engine.dialect.name in {"mysql", "mariadb"}:
            pixel = sa.func.floor(pixel)
        query = (
            sa.select(sa.func.min(table.c.value), sa.func.max(table.c.value))
            .where(table.c.time_us.between(from_us, to_us))
            .group_by(pixel)
        )
        before = time.perf_counter()
        with self.engine.begin() as connection:
            connection.execute(query).all()
        return time.perf_counter() - before


def database_bytes(url: str) -> int:
    """Give what a database takes on a server, once it has been vacuumed or analysed."""
    engine = sa.create_engine(url, isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        if engine.dialect.name == "postgresql":
            connection.exec_driver_sql("VACUUM")
            query = (
                "SELECT sum(pg_total_relation_size(oid)) FROM pg_class"
                " WHERE relkind = 'r' AND relnamespace = 'public'::regnamespace"
            )
        else:
            names = sa.inspect(connection).get_table_names()
            connection.exec_driver_sql("ANALYZE TABLE " + ", ".join(names)).all()
            query = (
                "SELECT sum(data_length + index_length) FROM information_schema.tables"
                " WHERE table_schema = DATABASE()"
            )
        size = int(connection.exec_driver_sql(query).scalar() or 0)
    engine.dispose()
    return size
