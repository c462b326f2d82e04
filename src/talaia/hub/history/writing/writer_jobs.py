"""What the writing thread is asked to do."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.hub.history.errors import HistoryError
from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.hub.history.writing.retention import Doomed

__all__ = [
    "Append",
    "Below",
    "Describe",
    "Drop",
    "GapJob",
    "Job",
    "Rename",
    "Show",
    "checked_columns",
]


class Append(NamedTuple):
    """Store a batch; sample i has the sequence number ``first + i``."""

    site: str
    boot: str
    first: int
    addresses: Sequence[str]
    columns: Columns


class GapJob(NamedTuple):
    """Store that ``first`` to ``last`` of a boot are lost."""

    site: str
    boot: str
    first: int
    last: int
    from_us: int
    to_us: int
    reason: str


class Below(NamedTuple):
    """Ask up to where a boot is stored without a hole."""

    site: str
    boot: str


class Describe(NamedTuple):
    """Give numbers to channels that may have no sample yet."""

    site: str
    addresses: Sequence[str]


class Rename(NamedTuple):
    """Let channels go on under other addresses; ``moves`` has them by their former ones."""

    site: str
    moves: Mapping[str, str]


class Show(NamedTuple):
    """Write the newest reading of each channel as a plain row."""


class Drop(NamedTuple):
    """Delete blocks."""

    doomed: Sequence[Doomed]


Job = Append | GapJob | Below | Describe | Rename | Show | Drop


def checked_columns(job: Append) -> Columns:
    """Give a batch's columns in the types they are stored in.

    Raises:
        HistoryError: they do not fit together.

    """
    columns = job.columns
    count = columns.channel.size
    problem = ""
    if job.first < 0 or job.first + count > 2**63 - 1:
        problem = f"its first sequence number is {job.first}"
    elif columns.time_us.size != count or columns.value.size != count:
        problem = f"its columns have {count}, {columns.time_us.size} and {columns.value.size} rows"
    elif count and int(columns.channel.max()) >= len(job.addresses):
        problem = f"it names channel {columns.channel.max()} of {len(job.addresses)}"
    elif any(not 0 <= position < count for position in columns.texts):
        problem = "a text stands outside of it"
    if problem:
        raise HistoryError(f"a batch from {job.site} cannot be stored: {problem}")
    return Columns(
        columns.channel,
        columns.time_us.astype(np.int64, copy=False),
        columns.value.astype(np.float64, copy=False),
        columns.texts,
    )
