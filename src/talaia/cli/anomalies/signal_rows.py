"""Rows of a CSV table with a column of times and one for each signal, read one by one."""

from __future__ import annotations

import csv
import io
import math
from typing import TYPE_CHECKING, NamedTuple
from zoneinfo import ZoneInfo

from talaia.cli.errors import BadRows
from talaia.cli.importing.times import TIME_NAMES, CellError, TimeReader

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

__all__ = ["LABEL_NAMES", "MeasuredRow", "SignalRows"]

# Headings of what people say about rows: a detector must not see them.
LABEL_NAMES = ("anomaly", "anomalies", "is_anomaly", "changepoint", "label")
# A line is no longer (letters), so that a file without line ends does not fill the memory.
_LONGEST_LINE = 1_000_000


class MeasuredRow(NamedTuple):
    """One row: its line in the file, its time as written and in µs, and the signals' values."""

    line: int
    time: str
    time_us: int
    # NaN where a cell is empty or holds no finite number.
    values: list[float]
    # What the file says of the row, where it has a column ``anomaly``.
    labelled: bool


class SignalRows:
    """A table that is read from its top to its bottom, a row at a time.

    Attributes:
        signals: headings of the columns that are read, in their order.
        left_out: headings of those that are not.

    """

    def __init__(
        self,
        path: Path,
        *,
        time_column: str = "",
        chosen: Sequence[str] = (),
        ignored: Sequence[str] = (),
        zone: ZoneInfo | None = None,
    ) -> None:
        """Open a file and read its headings.

        Args:
            path: UTF-8, with commas, semicolons or tabs.
            time_column: heading of the times; empty looks for a usual one.
            chosen: headings of the signals; none: all but labels (`LABEL_NAMES`).
            ignored: headings that are no signals.
            zone: of times that say none; None: UTC.

        Raises:
            BadRows: it cannot be read, or a column is missing.

        """
        self._path = path
        self._times = TimeReader(zone or ZoneInfo("UTC"))
        try:
            # The byte order mark is what spreadsheets begin UTF-8 with; the csv reader sees to
            # line ends.
            self._text = io.TextIOWrapper(path.open("rb"), "utf-8-sig", newline="")
        except OSError as error:
            raise BadRows(str(path), "", f"it cannot be opened: {error.strerror}") from error
        try:
            first = self._first_line()
            # The one that the heading has most of: values may hold commas, headings seldom do.
            delimiter = max(",;\t", key=first.count)
            # Strict: an open quotation mark would else swallow the rest of the file as one cell.
            self._reader = csv.reader([first], delimiter=delimiter, strict=True)
            first_row = self._next_row(1) or []
            self._reader = csv.reader(self._read_lines(), delimiter=delimiter, strict=True)
            self._headings = [heading.strip() for heading in first_row]
            self._time_at = self._find_time(time_column)
            self._places = self._find_signals(chosen, ignored)
        except BadRows:
            self.close()
            raise
        self.signals = [self._headings[at] for at in self._places]
        used = {self._time_at, *self._places}
        self.left_out = [name for at, name in enumerate(self._headings) if at not in used]
        lower = [heading.lower() for heading in self._headings]
        self._label_at = lower.index("anomaly") if "anomaly" in lower else -1
        if self._label_at in self._places:
            self._label_at = -1

    def close(self) -> None:
        """Close the file."""
        self._text.close()

    def read_rows(self) -> Iterator[MeasuredRow]:
        """Read the rows; empty lines are passed over.

        Raises:
            BadRows: a row cannot be read; those before it were given.

        """
        reader = self._reader
        while True:
            # The heading was read before this reader began to count.
            line = reader.line_num + 2
            row = self._next_row(line)
            if row is None:
                return
            if any(map(str.strip, row)):
                yield self._parse_row(row, line)

    def _first_line(self) -> str:
        try:
            return next(self._read_lines(), "")
        except (UnicodeDecodeError, csv.Error, OSError) as error:
            raise self._unreadable(1, error) from error

    def _read_lines(self) -> Iterator[str]:
        while line := self._text.readline(_LONGEST_LINE + 1):
            if len(line) > _LONGEST_LINE:
                raise csv.Error(f"a line is longer than {_LONGEST_LINE} letters")
            yield line

    def _next_row(self, line: int) -> list[str] | None:
        try:
            return next(self._reader, None)
        except (UnicodeDecodeError, csv.Error, OSError) as error:
            raise self._unreadable(line, error) from error

    def _unreadable(self, line: int, error: Exception) -> BadRows:
        why = f"not UTF-8 ({error.reason})" if isinstance(error, UnicodeDecodeError) else str(error)
        problem = f"expected a row of a CSV table: {why}"
        return self._cell_error(line, problem, remedy="save it as CSV in UTF-8")

    def _parse_row(self, row: list[str], line: int) -> MeasuredRow:
        # A decimal comma unquoted shifts all that follows by one column.
        if len(row) != len(self._headings):
            raise self._cell_error(
                line,
                f"expected {len(self._headings)} cells as in the heading, found {len(row)}",
                remedy="write a point for the decimals, and quote cells that hold the separator",
            )
        time = row[self._time_at].strip()
        try:
            time_us = self._times.read_time(time)
        except CellError as error:
            raise self._cell_error(line, str(error), self._headings[self._time_at]) from error
        cells = [row[at] for at in self._places]
        try:
            # Most rows hold numbers and nothing else, and take a third of the time so.
            values = list(map(float, cells))
        except ValueError:
            values = []
        if not values or "_" in "".join(cells) or not all(map(math.isfinite, values)):
            values = [self._parse_value(row[at], line, at) for at in self._places]
        labelled = self._label_at >= 0 and self._is_labelled(row[self._label_at], line)
        return MeasuredRow(line, time, time_us, values, labelled)

    def _parse_value(self, cell: str, line: int, at: int) -> float:
        text = cell.strip()
        if not text:
            return math.nan
        try:
            # Python would take 1_000 for a number; a table means something else by it.
            value = float(text) if "_" not in text else None
        except ValueError:
            value = None
        if value is None:
            name = self._headings[at]
            remedy = f"leave the column out with --ignore '{name}', or write a point for decimals"
            raise self._cell_error(line, f"expected a number, found {text[:40]!r}", name, remedy)
        # An infinity is what some programs write for no value, and means no more than NaN here.
        return value if math.isfinite(value) else math.nan

    def _is_labelled(self, cell: str, line: int) -> bool:
        text = cell.strip().lower()
        if text in ("", "0", "0.0", "false"):
            return False
        if text in ("1", "1.0", "true"):
            return True
        name = self._headings[self._label_at]
        raise self._cell_error(line, f"expected 0 or 1, found {cell[:40]!r}", name)

    def _find_time(self, asked: str) -> int:
        if asked:
            return self._place_of(asked)
        lower = [heading.lower() for heading in self._headings]
        for name in TIME_NAMES:
            if name in lower:
                return lower.index(name)
        raise self._cell_error(
            1,
            "expected a heading with a column of times (time, timestamp, datetime, …)",
            remedy=f"name it with --time; {self._there_are()}",
        )

    def _find_signals(self, chosen: Sequence[str], ignored: Sequence[str]) -> list[int]:
        left = {self._place_of(name) for name in ignored} | {self._time_at}
        if chosen:
            return [at for at in dict.fromkeys(map(self._place_of, chosen)) if at not in left]
        places = [
            at
            for at, heading in enumerate(self._headings)
            if at not in left and heading.lower() not in LABEL_NAMES
        ]
        if not places:
            problem = "expected a column for each signal beside the times"
            raise self._cell_error(1, problem, remedy=self._there_are())
        return places

    def _place_of(self, heading: str) -> int:
        if heading not in self._headings:
            problem = f"there is no column {heading!r}"
            raise self._cell_error(1, problem, remedy=self._there_are())
        return self._headings.index(heading)

    def _there_are(self) -> str:
        return "there are " + ", ".join(repr(heading[:40]) for heading in self._headings[:20])

    def _cell_error(self, line: int, problem: str, column: str = "", remedy: str = "") -> BadRows:
        place = f"line {line}" + (f", column {column!r}" if column else "")
        return BadRows(str(self._path), place, problem, remedy)
