"""Every stored sample of some channels, as Arrow: whole, in pieces, or straight into a file.

The hub streams its export, one row for each time stamp and one column for each channel, so a
window may be larger than the memory of either side.
"""

from __future__ import annotations

import asyncio
import importlib
import os
from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from talaia.client.errors import BadSettings, HistoryCut
from talaia.client.http_requests import quote_segment

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, Callable, Sequence
    from pathlib import Path

    from talaia.client.http_requests import BodyStream
    from talaia.client.hub_api import HubApi

__all__ = [
    "HistoryForm",
    "HistoryWindow",
    "read_table",
    "save_file",
    "stream_batches",
    "write_body",
]

HistoryForm = Literal["csv", "parquet", "arrow"]

# Of one piece of a file that is saved (bytes).
_PIECE = 256 * 1024


class HistoryWindow(NamedTuple):
    """What is asked for: signals or channels of one site, by its own addresses, and the time."""

    site: str
    signals: Sequence[str]
    since_us: int
    until_us: int
    # 0: every sample; otherwise what a chart of so many pixels shows.
    width: int = 0

    def query(self, form: HistoryForm) -> list[tuple[str, str]]:
        """Give the query of an export."""
        return [
            *(("signal", signal) for signal in self.signals),
            ("from_us", str(self.since_us)),
            ("to_us", str(self.until_us)),
            ("width", str(self.width)),
            ("format", form),
        ]

    @property
    def path(self) -> str:
        """The path of an export."""
        return f"/api/sites/{quote_segment(self.site)}/export"


async def read_table(api: HubApi, window: HistoryWindow) -> Any:  # noqa: ANN401 - pyarrow.Table
    """Read a window whole.

    Raises:
        HistoryCut: the answer ended before its end.
        ClientError: the hub cannot be asked, or says no.

    """
    pyarrow = _import_pyarrow()
    streams: list[BodyStream] = []

    def read() -> object:
        with api.requests.open_stream(window.path, query=window.query("arrow")) as stream:
            streams.append(stream)
            return _open_arrow(pyarrow, stream).read_all()

    try:
        return await api.read_again(read)
    finally:
        # A thread that still reads for nobody ends by this.
        for stream in streams:
            stream.abort()


async def stream_batches(api: HubApi, window: HistoryWindow) -> AsyncGenerator[Any]:
    """Give a window as `pyarrow.RecordBatch` objects, one after the other.

    Raises:
        HistoryCut: the answer ended before its end.
        ClientError: the hub cannot be asked, or says no.

    """
    pyarrow = _import_pyarrow()
    with ExitStack() as stack:

        def begin() -> tuple[BodyStream, Any]:
            asked = api.requests.open_stream(window.path, query=window.query("arrow"))
            stream = stack.enter_context(asked)
            return stream, _open_arrow(pyarrow, stream)

        stream, reader = await api.read_again(begin)
        # Before the connection is closed: a thread may be reading it.
        stack.callback(stream.abort)
        while True:
            batch = await asyncio.to_thread(_next_batch, reader)
            if batch is None:
                return
            yield batch


async def save_file(api: HubApi, path: Path, window: HistoryWindow, *, form: HistoryForm) -> int:
    """Save a window as a file; give its size in bytes. The file is there whole, or not at all.

    Raises:
        HistoryCut: the answer ended before its end.
        BadSettings: the file cannot be written.
        ClientError: the hub cannot be asked, or says no.

    """

    def save() -> int:
        with api.requests.open_stream(window.path, query=window.query(form)) as stream:
            return write_body(stream, path)

    return await api.read_again(save)


def write_body(
    stream: BodyStream,
    path: Path,
    *,
    size: int | None = None,
    report: Callable[[int], None] | None = None,
) -> int:
    """Write an answer into a file that is there whole or not at all; give its size in bytes.

    Raises:
        HistoryCut: the answer ended before its end (``size``, where that is known).
        BadSettings: the file cannot be written.

    """
    # Beside it, so that it can be moved into place; with our number, so that two do not share it.
    fresh = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with fresh.open("wb") as file:
            written = 0
            while piece := stream.read(_PIECE):
                file.write(piece)
                written += len(piece)
                if report is not None:
                    report(written)
        if size is not None and written != size:
            raise HistoryCut(f"{written} of {size} bytes came; ask again")
        fresh.replace(path)
    except OSError as error:
        raise BadSettings(f"{path} cannot be written: {error.strerror}") from error
    finally:
        with suppress(OSError):
            # Moved into place already, as a rule.
            fresh.unlink()
    return written


def _import_pyarrow() -> Any:  # noqa: ANN401 - the module
    try:
        return importlib.import_module("pyarrow")
    except ModuleNotFoundError as error:
        raise BadSettings(
            "the history comes as Arrow, and pyarrow is not installed; run:"
            " pip install 'talaia[client]'"
        ) from error


def _open_arrow(pyarrow: Any, stream: BodyStream) -> Any:  # noqa: ANN401
    ipc = importlib.import_module("pyarrow.ipc")
    try:
        return ipc.open_stream(pyarrow.PythonFile(stream, mode="r"))
    # Of a damaged head pyarrow says either.
    except (pyarrow.ArrowInvalid, OSError) as error:
        raise HistoryCut(f"the hub's answer is no Arrow stream: {error}") from error


def _next_batch(reader: Any) -> Any:  # noqa: ANN401
    try:
        return reader.read_next_batch()
    # Not let through: within a thread's future it would mean something else.
    except StopIteration:
        return None
