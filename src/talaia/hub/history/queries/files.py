"""Rows as CSV, Parquet or Arrow by pyarrow, a piece at a time: what is written is let go of."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from talaia.hub.history.queries.csv_file import TIME, csv_heading, text_cells
from talaia.hub.history.queries.export_formats import FileForm

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from talaia.hub.history.blocks.block import BlockSamples
    from talaia.hub.history.queries.export_formats import ExportColumn
    from talaia.hub.history.queries.wide_table import Rows

__all__ = ["write_file"]

# Rows of a Parquet file that are read together; smaller ones make the file larger.
_ROW_GROUP = 131_072
# Of so many values at the beginning it is told whether a column says few things again and again.
_LOOKED_AT = 32_768
_FEW = 4
# What compressing leaves of them at least where it is not worth its time.
_WORTH_LESS = 0.9


def write_file(
    form: FileForm, columns: list[ExportColumn], pieces: Iterator[Rows]
) -> Iterator[bytes]:
    """Give the bytes of a file, in pieces of which none is empty."""
    sink = _Sink()
    writer = _make_writer(form, columns, sink)
    for rows in pieces:
        writer.write(_make_table(form, columns, rows))
        if sink.size:
            yield sink.drain_bytes()
    writer.close()
    if sink.size:
        yield sink.drain_bytes()


class _Writer(Protocol):
    def write(self, table: pa.Table) -> None: ...

    def close(self) -> None: ...


class _Sink(io.RawIOBase):
    """A file that is taken away while it is written."""

    def __init__(self) -> None:
        super().__init__()
        self._parts: list[bytes] = []
        self._position = 0
        self.size = 0

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int:  # noqa: ANN401 - whatever pyarrow hands over
        part = bytes(data)
        self._parts.append(part)
        self._position += len(part)
        self.size += len(part)
        return len(part)

    def tell(self) -> int:
        return self._position

    def drain_bytes(self) -> bytes:
        """Give what was written since the last call."""
        parts, self._parts, self.size = self._parts, [], 0
        return b"".join(parts)


class _Csv:
    def __init__(self, sink: _Sink, columns: list[ExportColumn]) -> None:
        self._sink = sink
        sink.write(csv_heading(columns))

    def write(self, table: pa.Table) -> None:
        out = io.BytesIO()
        options = pyarrow.csv.WriteOptions(include_header=False, quoting_style="needed")
        pyarrow.csv.write_csv(table, out, options)
        self._sink.write(out.getvalue())

    def close(self) -> None:
        """Everything is written already."""


class _Gathered:
    """Gathers rows until they are worth a row group."""

    def __init__(self, sink: _Sink, columns: list[ExportColumn]) -> None:
        self._sink = sink
        self._columns = columns
        # Made with the first rows: how they are best written goes by what they say.
        self._writer: pyarrow.parquet.ParquetWriter | None = None
        self._held: list[pa.Table] = []

    def write(self, table: pa.Table) -> None:
        self._held.append(table)
        if sum(batch.num_rows for batch in self._held) >= _ROW_GROUP:
            self._flush_tables()

    def close(self) -> None:
        if self._held or self._writer is None:
            self._flush_tables()
        if self._writer is not None:
            self._writer.close()

    def _flush_tables(self) -> None:
        table = pa.concat_tables([_table_schema(self._columns).empty_table(), *self._held])
        if self._writer is None:
            self._writer = _open_parquet(self._sink, self._columns, table)
        if table.num_rows:
            self._writer.write_table(table)
        self._held = []


def _open_parquet(
    sink: _Sink, columns: list[ExportColumn], table: pa.Table
) -> pyarrow.parquet.ParquetWriter:
    """Begin a Parquet file in the way that takes least time for rows like these.

    Times rise by nearly the same steps: as differences they need no compression. Readings of a
    sensor with a few decimals are few different numbers: as numbers of a list they take a third of
    the room, and no more time. Where they are many, to make that list is most of the work. Where
    they are noise to their last bits, compressing takes most of the time and saves next to nothing.
    Least and greatest values, by which readers pass over parts of a file, are those of the times.
    """
    listed = [column.address for column in columns if column.worded]
    repeating, noisy = [], []
    for column in columns:
        if column.worded:
            continue
        values = _first_values(table.column(column.address))
        if _repeats(values):
            repeating.append(column.address)
        elif _is_noise(values):
            noisy.append(column.address)
    compression = {column.address: "zstd" for column in columns} | {TIME: "none"}
    return pyarrow.parquet.ParquetWriter(
        sink,
        table.schema,
        compression=compression | dict.fromkeys([*repeating, *noisy], "none"),
        write_statistics=[TIME],
        use_dictionary=[*listed, *repeating],
        column_encoding={TIME: "DELTA_BINARY_PACKED"},
    )


def _first_values(column: pa.ChunkedArray) -> pa.Array:
    found: list[pa.Array] = []
    # A channel that shares no times with the others has few values in many rows.
    for first in range(0, len(column), _LOOKED_AT):
        missing = _LOOKED_AT - sum(map(len, found))
        if not missing:
            break
        part = column.slice(first, _LOOKED_AT).drop_null().slice(0, missing)
        found += part.chunks
    return pa.concat_arrays(found) if found else pa.array([], column.type)


def _repeats(values: pa.Array) -> bool:
    return len(values) > 0 and _FEW * len(values.unique()) <= len(values)


def _is_noise(values: pa.Array) -> bool:
    if not len(values):
        return False
    plain = values.buffers()[1].slice(8 * values.offset, 8 * len(values))
    return bool(len(pa.compress(plain, "zstd", asbytes=True)) > _WORTH_LESS * plain.size)


def _make_writer(form: FileForm, columns: list[ExportColumn], sink: _Sink) -> _Writer:
    if form is FileForm.CSV:
        return _Csv(sink, columns)
    if form is FileForm.PARQUET:
        return _Gathered(sink, columns)
    stream: _Writer = pa.ipc.new_stream(sink, _table_schema(columns))
    return stream


def _table_schema(columns: list[ExportColumn]) -> pa.Schema:
    fields = [pa.field(TIME, pa.timestamp("us", "UTC"), nullable=False)]
    for column in columns:
        kind = pa.string() if column.worded else pa.float64()
        fields.append(pa.field(column.address, kind, metadata={"unit": column.unit}))
    return pa.schema(fields)


def _make_table(form: FileForm, columns: list[ExportColumn], rows: Rows) -> pa.Table:
    size = rows.time_us.size
    arrays = [_plain_array(pa.timestamp("us", "UTC"), rows.time_us)]
    for column, places, part in zip(columns, rows.places, rows.parts, strict=True):
        # A channel that has changed its type keeps its texts where a column can mix them.
        worded = column.worded or (form is FileForm.CSV and bool(part.texts))
        if worded:
            cells = text_cells(column, part, places, size, safe=form is FileForm.CSV)
            arrays.append(pa.array(cells, pa.string()))
        else:
            arrays.append(_number_array(part, places, size))
    if form is FileForm.CSV:
        return pa.table(arrays, names=[str(at) for at in range(len(arrays))])
    return pa.table(arrays, schema=_table_schema(columns))


def _number_array(part: BlockSamples, places: NDArray[np.intp], size: int) -> pa.Array:
    # Where the robot said NaN stands NaN; where it said nothing stands null.
    if places.size == size and not part.texts:
        return _plain_array(pa.float64(), part.value)
    value = np.zeros(size)
    value[places] = part.value
    there = np.zeros(size, bool)
    there[places] = True
    if part.texts:
        there[places[list(part.texts)]] = False
    return _plain_array(pa.float64(), value, np.packbits(there, bitorder="little"))


def _plain_array(
    kind: pa.DataType, column: NDArray[Any], there: NDArray[np.uint8] | None = None
) -> pa.Array:
    """Give a column as it is in memory; ``there`` has a bit for each row that is not null.

    `pyarrow.array` would look at what it is given first, for which it imports pandas.
    """
    data = pa.py_buffer(np.ascontiguousarray(column))
    bits = None if there is None else pa.py_buffer(there)
    return pa.Array.from_buffers(kind, column.size, [bits, data])
