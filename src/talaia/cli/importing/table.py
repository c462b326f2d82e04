"""A CSV table to samples: a column of times, and a column for each channel."""

from __future__ import annotations

import csv
import io
import math
import re
from typing import TYPE_CHECKING, NamedTuple

from talaia.cli.errors import BadFile
from talaia.cli.importing.source import Findings, Piece
from talaia.cli.importing.times import TIME_NAMES, CellError, TimeReader
from talaia.gateway.adapters.topic_readers import SampleBuffer
from talaia.gateway.samples.field_paths import text_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from talaia.model.site import Signal, Site

__all__ = ["Table"]

# An address and a unit in parentheses, as exported files head their columns.
_WITH_UNIT = re.compile(r"(?P<name>.*\S)\s+\((?P<unit>[^()]*)\)")
# Rows between two pieces.
_AT_ONCE = 4096


class _Column(NamedTuple):
    """A column that is read: where it stands, its heading, and what its cells mean."""

    # From 0, as cells stand in a row.
    at: int
    heading: str
    channel: int
    text: bool
    # Words of the signal's states; a cell may have the word or its number.
    states: tuple[str, ...]


class Table:
    """A `Source` of a table. Values are in the signals' own units; no scale is applied."""

    kind = "CSV"

    def __init__(
        self,
        path: Path,
        site: Site,
        *,
        named: Mapping[str, str],
        time_column: str,
        times: TimeReader,
    ) -> None:
        """Open a file and match its headings.

        Args:
            path: UTF-8, with commas, semicolons or tabs.
            site: whose channels they are.
            named: heading to address, for columns that are not headed by an address.
            time_column: heading of the times; empty looks for a usual one.
            times: reads them.

        Raises:
            BadFile: it cannot be read, has no column of times, or lacks one that is named.

        """
        self.findings = Findings()
        self._path = path
        # Remembers the unit and the time above, so that one reader serves one table only.
        self._times = times
        try:
            # Progress is the position in the raw file: the csv reader itself does not know it.
            self._size = path.stat().st_size or 1
            self._raw = path.open("rb")
        except OSError as error:
            raise BadFile(str(path), "", f"it cannot be opened: {error.strerror}") from error
        try:
            # A byte order mark is what spreadsheets begin UTF-8 with; line ends are left to the csv
            # reader.
            text = io.TextIOWrapper(self._raw, "utf-8-sig", newline="")
            first = text.readline()
            # The one that the heading has most of: values may hold commas, headings seldom do.
            delimiter = max(",;\t", key=first.count)
            # Strict: an open quotation mark would else swallow the rest of the file as one cell.
            self._reader = csv.reader(text, delimiter=delimiter, strict=True)
            self._headings = next(csv.reader([first], delimiter=delimiter, strict=True), [])
            self._headings = [heading.strip() for heading in self._headings]
            self._time_at = self._find_time(time_column)
            self._columns = self._match_columns(site, named)
        except UnicodeDecodeError as error:
            self.close()
            raise self._cell_error(
                1, f"it is not UTF-8 ({error.reason} at byte {error.start})"
            ) from error
        except csv.Error as error:
            self.close()
            raise self._cell_error(1, str(error)) from error
        except BadFile:
            self.close()
            raise

    def read_pieces(self) -> Iterator[Piece]:
        """See `Source.pieces`."""
        gathered = SampleBuffer()
        waiting = 0
        while True:
            # The heading was read before this reader began to count.
            line = self._reader.line_num + 2
            try:
                row = next(self._reader, None)
            except UnicodeDecodeError as error:
                raise self._cell_error(line, f"it is not UTF-8 ({error.reason})") from error
            except csv.Error as error:
                raise self._cell_error(line, str(error)) from error
            if row is None:
                break
            # An empty line, as editors leave one at the end.
            if not any(cell.strip() for cell in row):
                continue
            self._read_row(row, line, gathered)
            waiting += 1
            if waiting == _AT_ONCE:
                waiting = 0
                columns = gathered.take_columns()
                if columns is not None:
                    # A block ahead of the row, for the text layer reads ahead.
                    yield Piece(min(1.0, self._raw.tell() / self._size), columns)
        columns = gathered.take_columns()
        if columns is not None:
            yield Piece(1.0, columns)
        if self._times.doubtful:
            self.findings.notes.append(
                f"{self._times.doubtful} times come twice by the zone's clock, when summer time"
                " ends; they were distinguished by their order"
            )

    def close(self) -> None:
        """See `Source.close`."""
        self._raw.close()

    def _read_row(self, row: list[str], line: int, gathered: SampleBuffer) -> None:
        # A decimal comma unquoted shifts all that follows by one column.
        if len(row) != len(self._headings):
            raise self._cell_error(
                line, f"expected {len(self._headings)} cells as in the heading, found {len(row)}"
            )
        try:
            time_us = self._times.read_time(row[self._time_at])
        except CellError as error:
            raise self._cell_error(line, str(error), self._headings[self._time_at]) from error
        for column in self._columns:
            cell = row[column.at]
            if column.text:
                # An empty cell is no sample, neither as text nor as number.
                if cell:
                    gathered.add_text(column.channel, time_us, text_of(cell))
            elif cell := cell.strip():
                try:
                    value = _parse_number(cell, column.states)
                except CellError as error:
                    raise self._cell_error(line, str(error), column.heading) from error
                gathered.add_number(column.channel, time_us, value)

    def _find_time(self, asked: str) -> int:
        if asked:
            if asked in self._headings:
                return self._headings.index(asked)
            raise self._cell_error(1, f"there is no column {asked!r}", remedy=self._there_are())
        lower = [heading.lower() for heading in self._headings]
        for name in TIME_NAMES:
            if name in lower:
                return lower.index(name)
        raise self._cell_error(
            1, "which column holds the times?", remedy=f"name it with --time; {self._there_are()}"
        )

    def _there_are(self) -> str:
        return "there are " + ", ".join(repr(heading[:40]) for heading in self._headings[:20])

    def _match_columns(self, site: Site, named: Mapping[str, str]) -> list[_Column]:
        channels = {channel.address: number for number, channel in enumerate(site.channels())}
        for heading, address in named.items():
            if heading not in self._headings:
                raise self._cell_error(
                    1, f"there is no column {heading!r}", remedy=self._there_are()
                )
            if address not in channels:
                near = ", ".join(sorted(channels)[:20])
                raise self._cell_error(
                    1, f"the description has no channel {address!r}", remedy=f"there are {near}"
                )
        columns: list[_Column] = []
        taken: dict[int, str] = {}
        for at, heading in enumerate(self._headings):
            if at == self._time_at:
                continue
            address, unit = named.get(heading, ""), ""
            if not address:
                found = _WITH_UNIT.fullmatch(heading)
                # The apostrophe is put before cells that a spreadsheet would take for formulas.
                plain = heading.removeprefix("'")
                address = plain if found is None or plain in channels else found["name"]
                unit = "" if found is None or plain in channels else found["unit"]
            if address not in channels:
                self.findings.unread[heading or f"column {at + 1}"] = "no channel of that name"
                continue
            number = channels[address]
            # Two columns would give one channel two values for the same time.
            if number in taken:
                raise self._cell_error(
                    1, f"{address} is in two columns, {taken[number]!r} and {heading!r}"
                )
            signal = _signal_of(site, number)
            # Not converted: which of the two was meant cannot be known from here.
            if unit and unit != signal.unit:
                self.findings.unread[heading] = f"{address} is in {signal.unit or 'no unit'}"
                continue
            taken[number] = heading
            channel = site.channels()[number]
            columns.append(_Column(at, heading, number, channel.text, signal.states))
        for address, number in channels.items():
            if number not in taken:
                self.findings.absent[address] = "the file has no such column"
        return columns

    def _cell_error(self, line: int, problem: str, column: str = "", remedy: str = "") -> BadFile:
        place = f"line {line}" + (f", column {column!r}" if column else "")
        return BadFile(str(self._path), place, problem, remedy)


def _signal_of(site: Site, number: int) -> Signal:
    channel = site.channels()[number]
    return site.devices[channel.device].signals[channel.signal]


def _parse_number(cell: str, states: tuple[str, ...]) -> float:
    if cell in states:
        return float(states.index(cell))
    try:
        # Python would take 1_000 for a number; a table means something else by it.
        value = float(cell) if "_" not in cell else None
    except ValueError:
        value = None
    # A state's number is a whole one; NaN is a gap in either.
    if value is not None and (not states or math.isnan(value) or value == value // 1):
        return value
    if states:
        raise CellError(f"expected one of {', '.join(states)}, found {cell[:40]!r}")
    hint = "; write a point for the decimals" if re.fullmatch(r"[+-]?\d+,\d+", cell) else ""
    raise CellError(f"expected a number, found {cell[:40]!r}{hint}")
