"""A measured number beside its limit, and how it is printed."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["Figure", "percentiles", "show_figures"]


class Figure(NamedTuple):
    """One measured number, its limit and its unit."""

    what: str
    measured: float
    limit: float
    unit: str


def percentiles(what: str, ages: np.ndarray, p50: float, p99: float) -> list[Figure]:
    """Give the two figures of a distribution of ages in ms."""
    if not ages.size:
        raise SystemExit(f"{what}: nothing arrived")
    return [
        Figure(f"{what}, p50 of {ages.size}", float(np.percentile(ages, 50)), p50, "ms"),
        Figure(f"{what}, p99", float(np.percentile(ages, 99)), p99, "ms"),
    ]


def show_figures(figures: Iterable[Figure]) -> int:
    """Print each, and give how many are over their limit."""
    over = 0
    for figure in figures:
        fits = figure.measured <= figure.limit
        over += not fits
        ratio = figure.measured / figure.limit if figure.limit else 0.0
        mark = "" if fits else "   OVER"
        print(
            f"   {figure.what:<56} {figure.measured:8.2f} {figure.unit:<11}"
            f" limit {figure.limit:6.1f}  ratio {ratio:5.2f}{mark}",
            flush=True,
        )
    return over
