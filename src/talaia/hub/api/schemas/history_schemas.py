"""JSON bodies of the history; the browser's types are made from these.

Times ending in ``_us`` are microseconds since the epoch (UTC).
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict

from talaia.hub.history.forecast import Warn  # noqa: TC001 - pydantic reads it

__all__ = [
    "ChannelStorageShape",
    "GapShape",
    "HistoryAnswer",
    "OutlierList",
    "OutlierShape",
    "OutlookShape",
    "ReadingShape",
    "SeriesShape",
    "StatisticsList",
    "StatisticsShape",
    "StorageShape",
    "StoredList",
    "StoredShape",
    "ValueList",
    "ValueShape",
]


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


# What is no number is null: JSON has no other word for it.
Number = Annotated[float | None, BeforeValidator(_finite)]


class _Shape(BaseModel):
    """A key that is not described is an error, not a silence."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class GapShape(_Shape):
    """Samples that are lost, and why."""

    from_us: int
    to_us: int
    reason: str


class SeriesShape(_Shape):
    """One channel's samples.

    Every one (``exact``) or the least and greatest of each bucket (``minmax``). ``v`` is null
    where there is no number; ``text`` is there for texts only.
    """

    address: str
    kind: Literal["exact", "minmax"]
    t_us: list[int]
    v: list[float | None]
    text: list[str] | None = None
    gaps: list[GapShape]


class HistoryAnswer(_Shape):
    """A window of the history."""

    series: list[SeriesShape]


class ValueShape(_Shape):
    """A channel's last sample before a time; ``v`` is null where there is no number."""

    address: str
    t_us: int
    v: Number
    text: str | None = None


class ValueList(_Shape):
    """One for each channel that has any, in the order asked for."""

    values: list[ValueShape]


class ReadingShape(_Shape):
    """One sample; ``v`` is null where there is no number."""

    t_us: int
    v: Number
    text: str | None = None


class StatisticsShape(_Shape):
    """A channel over a window.

    ``mean`` and ``deviation`` (standard, of all finite numbers) are null where there are none;
    ``gap_us`` is how much of the window lies in recorded gaps.
    """

    address: str
    count: int
    numbers: int
    low: ReadingShape | None
    high: ReadingShape | None
    mean: Number
    deviation: Number
    first: ReadingShape | None
    last: ReadingShape | None
    gap_us: int


class StatisticsList(_Shape):
    """One for each channel, in the order asked for."""

    statistics: list[StatisticsShape]


class OutlierShape(_Shape):
    """How many of a window's samples lie far outside its quartiles.

    ``low`` and ``high`` are the fences, ``k`` times the distance of the quartiles below ``first``
    and above ``third``; null of fewer than eight numbers. ``exact``: all ``samples`` finite numbers
    of the window were looked at; otherwise those of blocks spread evenly over it, of about
    ``stored`` in all. ``count`` is of those looked at.
    """

    address: str
    samples: int
    stored: int
    first: Number
    third: Number
    low: Number
    high: Number
    count: int
    exact: bool


class OutlierList(_Shape):
    """One for each channel, in the order asked for."""

    outliers: list[OutlierShape]


class StoredShape(_Shape):
    """A channel that has history; ``described``: the site's description has it still.

    ``name``, ``unit``, ``type``, ``states`` and ``decimals`` are those of its signal when it was
    last described; ``type`` is empty where that is not known.
    """

    address: str
    name: str
    unit: str
    type: str
    states: list[str]
    decimals: int
    described: bool
    samples: int
    first_us: int
    last_us: int


class StoredList(_Shape):
    """What of a site has history and is open to you."""

    channels: list[StoredShape]


class ChannelStorageShape(_Shape):
    """What a channel's history takes.

    ``name`` is its signal's; ``described``: its site's description has it still. ``day_bytes`` is
    its growth at the last week's rate; ``keep_days`` 0: it is kept for good.
    """

    site: str
    address: str
    name: str
    described: bool
    samples: int
    bytes: int
    day_bytes: int
    first_us: int
    last_us: int
    keep_days: float


class StorageShape(_Shape):
    """What all history takes, and when it will be full.

    ``kind`` is the database's, ``place`` where it is. ``database_bytes`` has all in it;
    ``spare_bytes`` are free inside a SQLite file. ``free_bytes`` is null, and ``disk_bytes`` 0, for
    a database server, whose disk is not the hub's to know. ``limit_bytes`` 0: no limit, so the
    disk is. ``day_bytes`` is the growth at the last week's rate. ``full_us`` is when the limit
    (``by_limit``) or the disk is reached at that rate, null if never or not known; ``oldest_us`` is
    the oldest sample's time then. ``kept_days``: with a limit, how far the history reaches back in
    the long run. ``warn``: see `Warn`; ``trouble``: why nothing can be stored at present;
    ``files_trouble``: why recordings and pictures cannot be stored or read at present.
    """

    kind: str
    place: str
    database_bytes: int
    spare_bytes: int
    blocks_bytes: int
    free_bytes: int | None
    disk_bytes: int
    limit_bytes: int
    day_bytes: int
    full_us: int | None
    by_limit: bool
    oldest_us: int | None
    kept_days: float | None
    warn: Warn
    trouble: str
    files_trouble: str
    channels: list[ChannelStorageShape]


class OutlookShape(_Shape):
    """Whether there is room for what comes; as in `StorageShape`."""

    trouble: str
    files_trouble: str
    warn: Warn
    full_us: int | None
    free_bytes: int | None
