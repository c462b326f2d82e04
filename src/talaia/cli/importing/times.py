"""A table's time cells to microseconds since the epoch (UTC). Pure, and exact to the microsecond.

What is finer is cut off, as a clock that counts microseconds would.
"""

from __future__ import annotations

import datetime as dt
import re
from decimal import Decimal
from enum import StrEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from zoneinfo import ZoneInfo

__all__ = ["TIME_NAMES", "CellError", "TimeReader", "TimeUnit"]

# Headings of times that tables have most; the first is the one that Talaia itself exports.
TIME_NAMES = ("time (utc)", "time", "timestamp", "datetime", "date", "stamp", "t")

_EPOCH = dt.datetime(1970, 1, 1)  # noqa: DTZ001 - differences of times in UTC
_EPOCH_UTC = _EPOCH.replace(tzinfo=dt.UTC)
_US = dt.timedelta(microseconds=1)
# What the history can tell apart; some 73 000 years either way.
_FARTHEST_US = 2**61
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)
# The basic form without separators (20240131T…) would be taken for a number by some.
_ISO = re.compile(r"\d{4}-\d{2}-\d{2}([T ].+)?", re.ASCII)


class TimeUnit(StrEnum):
    """How a table writes its times."""

    AUTO = "auto"
    ISO = "iso"
    S = "s"
    MS = "ms"
    US = "us"
    NS = "ns"


# Decimals: 64-bit nanoseconds are beyond what a float holds exactly.
_PER_US = {
    TimeUnit.S: Decimal(1_000_000),
    TimeUnit.MS: Decimal(1_000),
    TimeUnit.US: Decimal(1),
    TimeUnit.NS: Decimal("0.001"),
}
# Seconds since the epoch have 10 digits until the year 2286.
_UNITS = (
    (Decimal("1e11"), TimeUnit.S),
    (Decimal("1e14"), TimeUnit.MS),
    (Decimal("1e17"), TimeUnit.US),
)


class CellError(ValueError):
    """A cell that cannot be read; the text says what was expected."""


class TimeReader:
    """Reads the time cells of one table, from its top to its bottom.

    The unit of numbers is taken from the first of them. A clock time that comes twice, when
    summer time ends, is the first of the two unless that would be before the cell above.

    Attributes:
        unit: as found, or as told.
        doubtful: times that came twice by the zone's clock.

    """

    def __init__(self, zone: ZoneInfo | None = None, unit: TimeUnit = TimeUnit.AUTO) -> None:
        """Read times without a zone as those of ``zone``; without one they are refused."""
        # For times that say none.
        self._zone = zone
        # The cell above (µs); before the first one anything is later.
        self._above_us = -_FARTHEST_US
        # Settled by the first cell that is read, and kept: one column has one unit.
        self.unit = unit
        # For a note at the end of the import.
        self.doubtful = 0

    def read_time(self, cell: str) -> int:
        """Give a cell's time.

        Raises:
            CellError: it cannot be read.

        """
        text = cell.strip()
        if self.unit is TimeUnit.AUTO:
            self.unit = _unit_of(text)
        time_us = self._parse_iso(text) if self.unit is TimeUnit.ISO else self._read_number(text)
        if not -_FARTHEST_US < time_us < _FARTHEST_US:
            raise CellError(f"the time {text[:40]!r} is too far away")
        self._above_us = time_us
        return time_us

    def _read_number(self, text: str) -> int:
        if not _NUMBER.fullmatch(text):
            raise CellError(f"expected a time as a number ({self.unit}), found {text[:40]!r}")
        value = Decimal(text)
        # Before the floor: an exponent of 999 would make an integer of a thousand digits.
        if abs(value) > Decimal("1e30"):
            raise CellError(f"the time {text[:40]!r} is too far away")
        # Down, also before 1970: cutting toward zero would fold two microseconds into one.
        return int((value * _PER_US[self.unit]).__floor__())

    def _parse_iso(self, text: str) -> int:
        if not _ISO.fullmatch(text):
            raise CellError(f"expected a time like 2024-01-31T12:00:00Z, found {text[:40]!r}")
        try:
            found = dt.datetime.fromisoformat(text)
        except ValueError as error:
            raise CellError(f"the time {text[:40]!r} cannot be read: {error}") from error
        if found.tzinfo is dt.UTC:
            # Most tables', in half the time.
            return (found - _EPOCH_UTC) // _US
        if found.tzinfo is not None:
            # `timestamp()` is a float and loses microseconds far from the epoch.
            offset = found.utcoffset() or dt.timedelta()
            return (found.replace(tzinfo=None) - _EPOCH) // _US - offset // _US
        if self._zone is None:
            raise CellError(
                f"the time {text[:40]!r} says no zone; name it with --zone, as Europe/Madrid or UTC"
            )
        return self._local_time(found, self._zone, text)

    def _local_time(self, found: dt.datetime, zone: ZoneInfo, text: str) -> int:
        plain = (found - _EPOCH) // _US
        if zone.key == "UTC":
            # Its clock was never put: a third of what reading a time takes is saved.
            return plain
        # PEP 495: fold tells which of the two times is meant when a clock time comes twice.
        first, second = (
            plain - (found.replace(tzinfo=zone, fold=fold).utcoffset() or dt.timedelta()) // _US
            for fold in (0, 1)
        )
        if first == second:
            return first
        if second < first:  # the clock was put forward over it
            raise CellError(f"the clock of {zone.key} never showed {text[:40]!r}")
        self.doubtful += 1
        return first if first >= self._above_us else second


def _unit_of(text: str) -> TimeUnit:
    if not _NUMBER.fullmatch(text):
        return TimeUnit.ISO
    value = abs(Decimal(text))
    return next((unit for limit, unit in _UNITS if value < limit), TimeUnit.NS)
