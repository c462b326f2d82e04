"""JSON bodies of the history; the browser's types are made from these.

Times ending in ``_us`` are microseconds since the epoch (UTC).
"""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

__all__ = [
    "ChannelStorageShape",
    "ReadingShape",
    "StatisticsList",
    "StatisticsShape",
    "StorageShape",
    "StoredList",
    "StoredShape",
    "ValueList",
    "ValueShape",
]


class _Shape(BaseModel):
    """A key that is not described is an error, not a silence."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class ValueShape(_Shape):
    """A channel's last sample before a time; ``v`` is null where there is no number."""

    address: str
    t_us: int
    v: float | None
    text: str | None = None


class ValueList(_Shape):
    """One for each channel that has any, in the order asked for."""

    values: list[ValueShape]


class ReadingShape(_Shape):
    """One sample; ``v`` is null where there is no number."""

    t_us: int
    v: float | None
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
    mean: float | None
    deviation: float | None
    first: ReadingShape | None
    last: ReadingShape | None
    gap_us: int


class StatisticsList(_Shape):
    """One for each channel, in the order asked for."""

    statistics: list[StatisticsShape]


class StoredShape(_Shape):
    """A channel that has history; ``described``: the site's description has it still."""

    address: str
    described: bool
    samples: int
    first_us: int
    last_us: int


class StoredList(_Shape):
    """What of a site has history and is open to you."""

    channels: list[StoredShape]


class ChannelStorageShape(_Shape):
    """What a channel's history takes; ``keep_days`` 0: it is kept for good."""

    site: str
    address: str
    samples: int
    bytes: int
    day_bytes: int
    first_us: int
    last_us: int
    keep_days: float


class StorageShape(_Shape):
    """What all history takes, and when it will be full.

    ``free_bytes`` is null for a database server, whose disk is not the hub's to know.
    ``limit_bytes`` 0: no limit, so the disk is. ``day_bytes`` is the growth by the last 24 hours;
    ``full_us`` is when the limit or the disk is reached at that rate, null if never or not known.
    """

    database_bytes: int
    blocks_bytes: int
    free_bytes: int | None
    limit_bytes: int
    day_bytes: int
    full_us: int | None
    channels: list[ChannelStorageShape]
