"""Pairs of rows and columns that cost least in all. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["assign_pairs"]


def assign_pairs(costs: NDArray[np.float64]) -> list[tuple[int, int]]:
    """Pair rows with columns, as many as may be, so that the sum of the costs is least.

    The Hungarian method by shortest augmenting paths (Jonker and Volgenant 1987), for which SciPy
    would have to be read in: 80 MB and a third of a second for a table of a few rows.

    Args:
        costs: rows × columns; infinite where the two can never be a pair.

    Returns:
        Row and column of each pair, by rows.

    """
    if not costs.size:
        return []
    known = np.isfinite(costs)
    if not known.any():
        return []
    # A pair that cannot be costs more than all others together, and is left out in the end.
    dear = float(np.abs(costs[known]).max() + 1) * (min(costs.shape) + 1)
    table = np.where(known, costs, dear)
    turned = table.shape[0] > table.shape[1]
    if turned:
        table = table.T
    row_of = _solve_rows(table)
    pairs = [(row, column) for column, row in enumerate(row_of) if row >= 0]
    pairs = [(column, row) if turned else (row, column) for row, column in pairs]
    return sorted(pair for pair in pairs if known[pair])


def _solve_rows(table: NDArray[np.float64]) -> list[int]:
    """Give for each column its row, or -1; no more rows than columns."""
    rows, columns = table.shape
    # Prices of rows and columns; column 0 is where each search begins.
    row_price, price = np.zeros(rows + 1), np.zeros(columns + 1)
    row_of = np.zeros(columns + 1, int)
    for row in range(1, rows + 1):
        row_of[0], at = row, 0
        least = np.full(columns + 1, np.inf)
        came_from = np.zeros(columns + 1, int)
        done = np.zeros(columns + 1, bool)
        while row_of[at]:
            done[at] = True
            here = row_of[at]
            reduced = table[here - 1] - row_price[here] - price[1:]
            nearer = ~done[1:] & (reduced < least[1:])
            least[1:][nearer] = reduced[nearer]
            came_from[1:][nearer] = at
            step_to = int(np.where(done[1:], np.inf, least[1:]).argmin()) + 1
            step = least[step_to]
            row_price[row_of[done]] += step
            price[done] -= step
            least[~done] -= step
            at = step_to
        # Back along the path: each column gets the row of the one before.
        while at:
            row_of[at] = row_of[came_from[at]]
            at = int(came_from[at])
    return [int(row) - 1 for row in row_of[1:]]
