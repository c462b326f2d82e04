"""Where the pictures of a film are, from the tables at its beginning (ISO/IEC 14496-12). Pure.

A film may have been made by anyone who has a gateway's key: nothing in it is taken on trust.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.hub.live.recorded.errors import RecordingUnreadable

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["MOST_PICTURES", "FilmIndex", "find_tables", "read_index"]

# Of one film: ten hours at 30 Hz.
MOST_PICTURES = 1_080_000
_HEAD, _LONG_HEAD = 8, 16
# No film lasts longer (s): what says so is broken.
_MOST_S = 1_000_000
# Bytes of a format before the boxes inside it.
_FORMAT_BYTES = 86
_BROKEN = "the film's tables are broken"


class FilmIndex(NamedTuple):
    """What is needed to give one picture of a film.

    Attributes:
        codec: as browsers name it, such as ``avc1.42C01E``.
        description: what a decoder has to know before the first picture (``avcC``).
        times_us: of each picture from the first one, rising; int64 of shape (pictures,).
        keys: of each picture the last one up to it that needs none before it; int64, as above.
        offsets: where each begins in the file (bytes); int64, as above.
        sizes: bytes of each; int64, as above.

    """

    codec: str
    description: bytes
    times_us: np.ndarray
    keys: np.ndarray
    offsets: np.ndarray
    sizes: np.ndarray

    def picture_at(self, us: int) -> int:
        """Give which picture stands at a time (µs from the first): the last that has come."""
        return max(0, int(np.searchsorted(self.times_us, us, "right")) - 1)


class _Box(NamedTuple):
    kind: bytes
    begin: int
    end: int


def find_tables(head: bytes) -> tuple[int, int] | None:
    """Give where a film's tables lie (bytes from and to), by its first bytes; None: not in front.

    They may end beyond ``head``.
    """
    for box in _boxes(head, 0, len(head)):
        if box.kind == b"moov":
            return box.begin, box.end
        if box.kind == b"mdat" or box.end > len(head):
            return None
    return None


def read_index(tables: bytes, file_size: int) -> FilmIndex:
    """Read the tables, without their own head.

    Raises:
        RecordingUnreadable: they are broken, or not those of a film of ours.

    """
    try:
        return _read_index(memoryview(tables), file_size)
    except (struct.error, ValueError, IndexError, OverflowError) as error:
        raise RecordingUnreadable(_BROKEN) from error


def _read_index(data: memoryview, file_size: int) -> FilmIndex:
    media = _box_at(data, _Box(b"", 0, len(data)), b"trak", b"mdia")
    header = _box_at(data, media, b"mdhd")
    scale_at = header.begin + (20 if data[header.begin] == 1 else 12)
    (scale,) = struct.unpack_from(">I", data, scale_at)
    tables = _box_at(data, media, b"minf", b"stbl")
    known = {box.kind: box for box in _boxes(data, tables.begin, tables.end)}
    # Shown in another order than decoded: the encoder of gateways does not do so.
    if b"ctts" in known or not scale:
        raise RecordingUnreadable("the film's pictures do not stand in the order of their times")
    codec, description = _read_format(data, _known(known, b"stsd"))
    sizes = _read_sizes(data, _known(known, b"stsz"))
    count = len(sizes)
    steps = _read_rows(data, _known(known, b"stts"), 2)
    if int(steps[:, 0].sum()) != count:
        raise RecordingUnreadable(_BROKEN)
    ticks = np.cumsum(np.repeat(steps[:, 1], steps[:, 0]))
    if int(ticks[-1]) > _MOST_S * scale:
        raise RecordingUnreadable(_BROKEN)
    times_us = (np.concatenate([[0], ticks[:-1]]) * 1_000_000 + scale // 2) // scale
    offsets = _read_offsets(data, known, sizes)
    if int((offsets + sizes).max()) > file_size or int(sizes.sum()) > file_size:
        raise RecordingUnreadable("the film is shorter than its tables say")
    return FilmIndex(codec, description, times_us, _read_keys(data, known, count), offsets, sizes)


def _read_format(data: memoryview, box: _Box) -> tuple[str, bytes]:
    begin = box.begin + 8
    if bytes(data[begin + 4 : begin + 8]) != b"avc1":
        raise RecordingUnreadable("the film is not H.264")
    (size,) = struct.unpack_from(">I", data, begin)
    inside = _Box(b"avc1", begin + _FORMAT_BYTES, min(begin + size, box.end))
    found = _box_at(data, inside, b"avcC")
    description = bytes(data[found.begin : found.end])
    return f"avc1.{description[1:4].hex().upper()}", description


def _read_sizes(data: memoryview, box: _Box) -> np.ndarray:
    same, count = struct.unpack_from(">II", data, box.begin + 4)
    if not 0 < count <= MOST_PICTURES:
        raise RecordingUnreadable(f"the film has {count} pictures")
    if same:
        return np.full(count, same, np.int64)
    return _read_words(data, box, 12, count)


def _read_offsets(data: memoryview, known: dict[bytes, _Box], sizes: np.ndarray) -> np.ndarray:
    """Give where each picture begins: they follow one another in chunks."""
    if b"co64" in known:
        box, kind = known[b"co64"], ">i8"
    else:
        box, kind = _known(known, b"stco"), ">u4"
    (count,) = struct.unpack_from(">I", data, box.begin + 4)
    if count > len(sizes) or box.begin + 8 + count * int(kind[2]) > box.end:
        raise RecordingUnreadable(_BROKEN)
    chunks = np.frombuffer(data, kind, count, box.begin + 8).astype(np.int64)
    rows = _read_rows(data, _known(known, b"stsc"), 3)
    # Each row holds up to the chunk that the next one begins with; the first chunk is 1.
    ends = np.append(rows[1:, 0], count + 1)
    if (ends < rows[:, 0]).any() or int((ends - rows[:, 0]).sum()) != count:
        raise RecordingUnreadable(_BROKEN)
    in_chunk = np.repeat(rows[:, 1], ends - rows[:, 0])
    if int(in_chunk.sum()) != len(sizes) or chunks.min() < 0:
        raise RecordingUnreadable(_BROKEN)
    before = np.cumsum(sizes) - sizes
    firsts = np.cumsum(in_chunk) - in_chunk
    offsets: np.ndarray = np.repeat(chunks - before[firsts], in_chunk) + before
    return offsets


def _read_keys(data: memoryview, known: dict[bytes, _Box], count: int) -> np.ndarray:
    if b"stss" not in known:
        return np.arange(count)
    box = known[b"stss"]
    (keys,) = struct.unpack_from(">I", data, box.begin + 4)
    numbers = _read_words(data, box, 8, keys) - 1
    if not keys or numbers[0] != 0 or numbers[-1] >= count or (np.diff(numbers) <= 0).any():
        raise RecordingUnreadable(_BROKEN)
    return np.repeat(numbers, np.diff(np.append(numbers, count)))


def _read_rows(data: memoryview, box: _Box, width: int) -> np.ndarray:
    (count,) = struct.unpack_from(">I", data, box.begin + 4)
    return _read_words(data, box, 8, count * width).reshape(count, width)


def _read_words(data: memoryview, box: _Box, at: int, count: int) -> np.ndarray:
    """Read numbers of 32 bits; all of them have to be there."""
    if count > 3 * MOST_PICTURES or box.begin + at + 4 * count > box.end:
        raise RecordingUnreadable(_BROKEN)
    return np.frombuffer(data, ">u4", count, box.begin + at).astype(np.int64)


def _known(known: dict[bytes, _Box], kind: bytes) -> _Box:
    if kind not in known:
        raise RecordingUnreadable(f"the film has no {kind.decode()}")
    return known[kind]


def _box_at(data: memoryview, within: _Box, *path: bytes) -> _Box:
    box = within
    for kind in path:
        for inner in _boxes(data, box.begin, box.end):
            if inner.kind == kind and inner.end <= box.end:
                box = inner
                break
        else:
            raise RecordingUnreadable(f"the film has no {kind.decode()}")
    return box


def _boxes(data: bytes | memoryview, begin: int, end: int) -> Iterator[_Box]:
    at = begin
    while at + _HEAD <= min(end, len(data)):
        size, kind = struct.unpack_from(">I4s", data, at)
        head = _HEAD
        if size == 1:
            if at + _LONG_HEAD > len(data):
                return
            (size,) = struct.unpack_from(">Q", data, at + _HEAD)
            head = _LONG_HEAD
        elif size == 0:
            size = end - at
        if size < head:
            return
        yield _Box(kind, at + head, at + size)
        at += size
