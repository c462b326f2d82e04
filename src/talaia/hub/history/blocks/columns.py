"""Many rows of numbers as arrays; how they are asked for is each engine's own matter."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from talaia.hub.history.blocks.rows import to_float
from talaia.hub.store.dialects.choice import dialect_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray
    from sqlalchemy import Connection

    from talaia.hub.store.dialects.dialect import Query

__all__ = ["columns_of"]


def columns_of(
    connection: Connection, query: Query, parameters: Mapping[str, int]
) -> list[NDArray[Any]]:
    """Run a query whose columns are times (µs) and values in turn; NULL is NaN.

    Returns:
        As many int64 and float64 arrays, in turn, of the shape (rows,); none if there is no row.

    """
    columns = dialect_of(connection).fetch_columns(connection, query, parameters)
    return [
        to_float(column) if at % 2 else np.asarray(column, np.int64)
        for at, column in enumerate(columns)
    ]
