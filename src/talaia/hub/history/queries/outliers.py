"""The quartiles of a window, of every sample stored in it, and how many samples are far outside.

Blocks are looked at in an order that goes evenly over the window again and again, which `Ranks`
needs; of those that lie in the window as a whole only the values are decompressed. A step reads a
few blocks in a transaction of its own, so that who asks may stop, and others get their turn.

Of a window with more samples than `Limits.counted`, blocks spread evenly over it with about so many
are looked at, and the answer says how many that were.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from sqlalchemy import select

from talaia.hub.history.blocks.block import decode_block, decode_values, in_order
from talaia.hub.history.errors import HistoryError
from talaia.hub.history.queries.quantiles import KEPT, Ranks
from talaia.hub.history.queries.window_query import window_of
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray
    from sqlalchemy import Engine

    from talaia.hub.history.queries.window import StoredWindow
    from talaia.hub.history.writing.block_index import BlockIndex

__all__ = ["LEAST", "Outliers", "find_outliers", "scatter_parts"]

# Of fewer numbers quartiles say nothing.
LEAST = 8
_AT_ONCE = 32
_LOOKS = 3
_QUARTILES = (0.25, 0.75)
_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
_block = tables.block


class Outliers(NamedTuple):
    """What lies far outside the quartiles of a window, both ends included.

    Attributes:
        samples: finite numbers that were looked at.
        stored: the same if every sample was looked at; otherwise about how many there are.
        first: the lower quartile; NaN of fewer than `LEAST` numbers, like all below.
        third: the upper quartile.
        low: numbers below are outliers: ``first - k * (third - first)``.
        high: numbers above are outliers.
        outliers: how many there are among those looked at.
        exact: every sample of the window was looked at.

    """

    address: str
    samples: int
    stored: int
    first: float
    third: float
    low: float
    high: float
    outliers: int
    exact: bool


class _Part(NamedTuple):
    """A block that overlaps the window; ``whole`` where all of it lies within."""

    id: int
    samples: int
    low: float
    high: float
    whole: bool


def find_outliers(
    engine: Engine,
    ledger: BlockIndex,
    *,
    site: str,
    address: str,
    from_us: int,
    to_us: int,
    k: float,
    most: int,
) -> Iterator[Outliers | None]:
    """Go a step with each ``next``: None until it is done, then what was found."""
    found = window_of(ledger, site=site, address=address, from_us=from_us, to_us=to_us)
    if found is None:
        yield _no_outliers(address)
        return
    window, held = found
    tail = in_order(held).between_times(window.from_us, window.to_us).value
    parts, stored = _list_parts(engine, window, most)
    whole = sum(part.samples for part in parts) == stored
    quartiles: list[float] | None = None
    ranks = Ranks(_QUARTILES)
    for look in range(_LOOKS):
        ranks = Ranks(_QUARTILES, KEPT * 4**look)
        ranks.add_values(tail)
        # Another order each time: what misled the first look is not met alike in the next.
        for values in _read_values(engine, window, scatter_parts(parts, look)):
            if values is None:
                whole = False
            elif values.size:
                ranks.add_values(values)
                yield None
        quartiles = ranks.quantiles()
        if quartiles is not None:
            break
    if quartiles is None or ranks.count < LEAST:
        of = ranks.count if whole else stored
        yield _no_outliers(address)._replace(samples=ranks.count, stored=of, exact=whole)
        return
    first, third = quartiles
    low, high = first - k * (third - first), third + k * (third - first)
    count = _count_outside(tail, low, high)
    # What lies between the fences as a whole has none.
    far = [part for part in parts if not (part.low >= low and part.high <= high)]
    for values in _read_values(engine, window, far):
        if values is not None:
            count += _count_outside(values, low, high)
            yield None
    of = ranks.count if whole else stored
    yield Outliers(address, ranks.count, of, first, third, low, high, count, whole)


def scatter_parts(parts: Sequence[_Part], turn: int) -> list[_Part]:
    """Put parts in an order of which every beginning lies evenly among all of them."""
    places = (np.arange(len(parts)) + 1) * _GOLDEN + turn * _GOLDEN / 2.0
    return [parts[at] for at in np.argsort(np.argsort(places % 1.0)).tolist()]


def _no_outliers(address: str) -> Outliers:
    nan = math.nan
    return Outliers(address, 0, 0, nan, nan, nan, nan, 0, exact=True)


def _count_outside(values: NDArray[np.float64], low: float, high: float) -> int:
    # Of what is no number nothing is counted; infinities are none either.
    return int(np.count_nonzero(((values < low) | (values > high)) & np.isfinite(values)))


def _list_parts(engine: Engine, window: StoredWindow, most: int) -> tuple[list[_Part], int]:
    """List the blocks to look at, in order of time, and count the samples of all of them."""
    names = ("id", "samples", "low", "high", "first_us", "last_us")
    query = select(*(_block.c[name] for name in names)).where(*window.overlap_conditions())
    with engine.begin() as connection:
        rows = connection.execute(query.order_by(_block.c.first_us, _block.c.id)).all()
    parts = [
        _Part(
            row.id,
            row.samples,
            -math.inf if row.low is None else row.low,
            math.inf if row.high is None else row.high,
            window.from_us <= row.first_us and row.last_us <= window.to_us,
        )
        for row in rows
    ]
    stored = sum(part.samples for part in parts)
    if stored > most:
        every = math.ceil(stored / most)
        parts = parts[every // 2 :: every]
    return parts, stored


def _read_values(
    engine: Engine, window: StoredWindow, parts: Sequence[_Part]
) -> Iterator[NDArray[np.float64] | None]:
    """Give the values of blocks, a few blocks at a time; None for one that cannot be read."""
    body = tables.body
    for at in range(0, len(parts), _AT_ONCE):
        some = {part.id: part for part in parts[at : at + _AT_ONCE]}
        query = select(body).where(body.c.block_id.in_(list(some)))
        with engine.begin() as connection:
            rows = connection.execute(query).all()
        read: list[NDArray[np.float64]] = []
        for number, data in rows:
            try:
                read.append(_decode_values(window, some[number], data))
            except HistoryError:
                # The charts' reading says so in the log.
                yield None
        if len(rows) < len(some):
            yield None
        yield np.concatenate(read) if read else np.empty(0)


def _decode_values(window: StoredWindow, part: _Part, data: bytes) -> NDArray[np.float64]:
    if part.whole:
        return decode_values(data)
    return in_order(decode_block(data)).between_times(window.from_us, window.to_us).value
