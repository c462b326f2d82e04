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

    def __init__(self, writer: pyarrow.parquet.ParquetWriter) -> None:
        self._writer = writer
        self._held: list[pa.Table] = []

    def write(self, table: pa.Table) -> None:
        self._held.append(table)
        if sum(batch.num_rows for batch in self._held) >= _ROW_GROUP:
            self._flush_tables()

    def close(self) -> None:
        if self._held:
            self._flush_tables()
        self._writer.close()

    def _flush_tables(self) -> None:
        self._writer.write_table(pa.concat_tables(self._held))
        self._held = []


def _make_writer(form: FileForm, columns: list[ExportColumn], sink: _Sink) -> _Writer:
    if form is FileForm.CSV:
        return _Csv(sink, columns)
    if form is FileForm.PARQUET:
        return _Gathered(
            pyarrow.parquet.ParquetWriter(sink, _table_schema(columns), compression="zstd")
        )
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
    arrays = [pa.array(rows.time_us, pa.int64()).cast(pa.timestamp("us", "UTC"))]
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
    value = np.zeros(size)
    value[places] = part.value
    empty = np.ones(size, bool)
    empty[places] = False
    if part.texts:
        empty[places[list(part.texts)]] = True
    # Where the robot said NaN stands NaN; where it said nothing stands null.
    return pa.array(value, pa.float64(), mask=empty, from_pandas=False)
