"""Summaries as database rows, and back."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

import numpy as np

from talaia.hub.history.blocks.rollup import Cells

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray
    from sqlalchemy import Column, Table

__all__ = ["SUMMARY", "cells_to_rows", "rows_to_cells", "summary_of", "to_cells", "to_float"]

SUMMARY = Cells._fields[1:]
_FLOATS = frozenset(("total", "squares", "low", "high", "last"))
_MAX = sys.float_info.max


def summary_of(table: Table) -> list[Column[Any]]:
    """Name the columns of a summary in a table, in the order of `Cells`."""
    return [table.c[name] for name in SUMMARY]


def cells_to_rows(cells: Cells, **same: int) -> list[dict[str, Any]]:
    """Give a row for each cell; ``same`` are further columns that are the same in all."""
    columns = [
        to_cells(column) if name in _FLOATS else column.tolist()
        for name, column in zip(Cells._fields, cells, strict=True)
    ]
    return [
        {**same, **dict(zip(Cells._fields, row, strict=True))} for row in zip(*columns, strict=True)
    ]


def rows_to_cells(rows: Sequence[Sequence[Any]]) -> Cells:
    """Read rows of ``bucket_us`` and `SUMMARY` back."""
    columns = list(zip(*rows, strict=True)) or [()] * len(Cells._fields)
    arrays: list[NDArray[Any]] = [
        to_float(column) if name in _FLOATS else np.array(column, np.int64)
        for name, column in zip(Cells._fields, columns, strict=True)
    ]
    return Cells(*arrays)


def to_float(column: Sequence[float | None] | NDArray[np.float64]) -> NDArray[np.float64]:
    """Read values as they stand in a row: NULL is NaN, the greatest number is infinity."""
    value = np.array(column, np.float64)
    value[value >= _MAX] = np.inf
    value[value <= -_MAX] = -np.inf
    return value


def to_cells(column: NDArray[Any]) -> list[float | None]:
    """Give values, of shape (n,), as they stand in rows."""
    # MariaDB keeps no infinities, and neither it nor SQLite keeps NaN.
    if np.isfinite(column).all():
        return column.tolist()  # type: ignore[no-any-return]
    clipped: list[float] = np.clip(column, -_MAX, _MAX).tolist()
    return [None if value != value else value for value in clipped]
