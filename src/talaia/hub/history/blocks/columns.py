"""Many rows of numbers as arrays.

The servers' drivers are Python and take ten times longer to read a row than to read the same as
one long text, so servers are asked for a text of each column. SQLite's driver gives rows at once.
"""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np
from sqlalchemy import Text, case, cast, func, or_, select

from talaia.hub.history.blocks.rows import to_float

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray
    from sqlalchemy import Connection, Select
    from sqlalchemy.sql.selectable import CompoundSelect

    Query = Select[Any] | CompoundSelect[Any]

__all__ = ["columns_of"]


def columns_of(connection: Connection, query: Query) -> list[NDArray[Any]]:
    """Run a query whose columns are times (µs) and values in turn; NULL is NaN.

    Returns:
        As many int64 and float64 arrays, in turn, of the shape (rows,); none if there is no row.

    """
    dialect = connection.dialect.name
    if dialect == "sqlite":
        return _arrays(_plain_rows(connection, query))
    inner = query.subquery()
    columns = list(inner.c)
    if dialect == "postgresql":
        texts = [
            func.string_agg(func.coalesce(cast(column, Text), "nan"), ",") for column in columns
        ]
        return _read(connection.execute(select(*texts)).one())
    # MariaDB shortens a number that it turns into a text before it is gathered, so NULL cannot
    # become a word there; buckets of nothing but NaN are rare enough to ask again for all.
    without = case((or_(*(column.is_(None) for column in columns[1::2])), 1), else_=0)
    texts = [func.group_concat(func.ifnull(column, 0)) for column in columns]
    *found, empty = connection.execute(select(*texts, func.sum(without))).one()
    return _arrays(connection.execute(query).all()) if empty else _read(found)


def _read(texts: Sequence[str | None]) -> list[NDArray[Any]]:
    if texts[0] is None:
        return []
    return [
        to_float(np.fromstring(text or "", np.float64, sep=","))
        if at % 2
        else np.fromstring(text or "", np.int64, sep=",")
        for at, text in enumerate(texts)
    ]


def _plain_rows(connection: Connection, query: Query) -> Sequence[Sequence[Any]]:
    """Fetch rows as the driver makes them: to make SQLAlchemy's of them takes as long again."""
    result = connection.execute(query)
    rows: Sequence[Sequence[Any]] = result.cursor.fetchall()
    result.close()
    return rows


def _arrays(rows: Sequence[Sequence[Any]]) -> list[NDArray[Any]]:
    if not rows:
        return []
    # A zip of thousands of rows would make an iterator of each.
    flat, count = list(chain.from_iterable(rows)), len(rows[0])
    return [
        to_float(flat[at::count]) if at % 2 else np.array(flat[at::count], np.int64)
        for at in range(count)
    ]
