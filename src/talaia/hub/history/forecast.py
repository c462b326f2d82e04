"""When the history's room is used up, at the rate of the last week. Pure.

A signal that is kept for some days stops growing once it has that many. So the sum over all
signals grows along straight pieces, each less steep than the one before, and may never reach what
there is room for.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

__all__ = [
    "DAY_US",
    "WEEK_US",
    "Forecast",
    "Growth",
    "StorageRoom",
    "Warn",
    "forecast_storage",
    "growth_of",
]

DAY_US = 86_400_000_000
WEEK_US = 7 * DAY_US
# A store that is younger than this says little; its rate is taken as if it were so old.
_LEAST_US = DAY_US // 24
# Beyond a hundred years a forecast says nothing.
_FARTHEST_US = 36_525 * DAY_US
# A disk is nearly full with less than a twentieth left, and with less than so many bytes.
_SCARCE_SHARE = 0.05
_SCARCE_BYTES = 2_000_000_000


class Growth(NamedTuple):
    """How one channel grows.

    Attributes:
        rate: bytes a microsecond, in blocks.
        first_us: time of its oldest sample.
        keep_us: how long it is kept; 0 is for good.

    """

    rate: float
    first_us: int
    keep_us: int


class StorageRoom(NamedTuple):
    """What there is room for, in bytes.

    Attributes:
        blocks: what all blocks take now.
        limit: what they may take; 0 sets no limit.
        free: left on the disk, with what is free inside the database's file; None: not known.
        disk: the disk's size; 0: not known.
        share: bytes of the database for each byte of a block: rollups and indices come on top.

    """

    blocks: int
    limit: int
    free: int | None
    disk: int = 0
    share: float = 1.0


class Warn(StrEnum):
    """What an admin should know without asking.

    ``limit``: within a week the oldest samples begin to go. ``soon``: within a week the disk is
    full. ``full``: it nearly is.
    """

    NOTHING = ""
    LIMIT = "limit"
    SOON = "soon"
    FULL = "full"


class Forecast(NamedTuple):
    """What is to come.

    Attributes:
        day_bytes: what the database grows in a day now, before anything is dropped.
        full_us: when the limit or the disk is reached, whichever is first; None: never.
        by_limit: it is the limit, after which the oldest go; otherwise the disk, after which
            nothing more is stored.
        oldest_us: time of the oldest sample that is kept then; None if never.
        kept_us: with a limit: how far back the history reaches in the long run; None: for good,
            or as long as each signal is kept.

    """

    day_bytes: int
    full_us: int | None
    by_limit: bool
    oldest_us: int | None
    kept_us: int | None
    warn: Warn


def growth_of(week_bytes: int, first_us: int, keep_us: int, now_us: int) -> Growth:
    """Give a channel's growth from what it took in the last week."""
    age_us = min(WEEK_US, max(_LEAST_US, now_us - first_us))
    return Growth(week_bytes / age_us, first_us, keep_us)


def forecast_storage(room: StorageRoom, growing: Sequence[Growth], now_us: int) -> Forecast:
    """Say when the room is used up if all goes on as in the last week."""
    to_limit = to_disk = None
    if room.limit:
        to_limit = _time_to_fill(room.limit - room.blocks, _channel_growth(growing, now_us))
    if room.free is not None:
        to_disk = _time_to_fill(room.free / room.share, _channel_growth(growing, now_us))
    by_limit = to_limit is not None and (to_disk is None or to_limit <= to_disk)
    until = to_limit if by_limit else to_disk
    full_us = None if until is None else now_us + round(until)
    kept_us = None
    if room.limit:
        # In the long run every channel has as much as it keeps, or as the limit leaves it.
        reach = _time_to_fill(
            room.limit, [(channel.rate, channel.keep_us or None) for channel in growing]
        )
        kept_us = None if reach is None else round(reach)
    return Forecast(
        round(sum(channel.rate for channel in growing) * DAY_US * room.share),
        full_us,
        by_limit,
        None if full_us is None else _oldest_time(growing, full_us),
        kept_us,
        _storage_warning(room, until, by_limit=by_limit),
    )


def _channel_growth(growing: Iterable[Growth], now_us: int) -> list[tuple[float, int | None]]:
    """Give each channel's rate, and for how long (µs) it goes on growing."""
    return [
        (
            channel.rate,
            max(0, channel.first_us + channel.keep_us - now_us) if channel.keep_us else None,
        )
        for channel in growing
    ]


def _time_to_fill(size: float, pieces: Sequence[tuple[float, int | None]]) -> float | None:
    """Give after how long (µs) the sum of all has grown by ``size`` (bytes); None: never."""
    if size <= 0:
        return 0.0
    ends = sorted((end, rate) for rate, end in pieces if end is not None)
    steep = sum(rate for rate, _ in pieces)
    at = 0.0
    for end, rate in ends:
        grown = steep * (end - at)
        if grown >= size:
            break
        size -= grown
        at, steep = end, steep - rate
    # What is left of a difference of many rates is no growth.
    if steep <= 0 or size / steep > _FARTHEST_US or at + size / steep > _FARTHEST_US:
        return None
    return at + size / steep


def _oldest_time(growing: Iterable[Growth], at_us: int) -> int | None:
    return min(
        (
            max(channel.first_us, at_us - channel.keep_us) if channel.keep_us else channel.first_us
            for channel in growing
        ),
        default=None,
    )


def _storage_warning(room: StorageRoom, until: float | None, *, by_limit: bool) -> Warn:
    scarce = min(_SCARCE_BYTES, room.disk * _SCARCE_SHARE)
    if room.free is not None and room.free < scarce:
        return Warn.FULL
    if until is None or until >= WEEK_US:
        return Warn.NOTHING
    if not by_limit:
        return Warn.SOON
    # Once it is reached, that the oldest go is how it is meant to be.
    return Warn.LIMIT if room.blocks < room.limit else Warn.NOTHING
