"""The records of an MCAP file that its reading by index needs.

Read here, since the library of the format brings a compressor of 24 MB to every hub.

Source: the MCAP specification, version 0 (https://mcap.dev/spec). Unknown records are passed over,
and of known ones the fields that a later version may add.
"""

from __future__ import annotations

import struct
import sys
import zlib
from typing import TYPE_CHECKING, NamedTuple

import lz4.frame

if sys.version_info >= (3, 14):
    from compression.zstd import ZstdDecompressor
else:
    from backports.zstd import ZstdDecompressor

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from typing import BinaryIO

__all__ = [
    "ChannelRecord",
    "ChunkIndexRecord",
    "McapDamaged",
    "McapSummary",
    "MessageRecord",
    "SchemaRecord",
    "messages_of_chunk",
    "read_mcap_summary",
]

_MAGIC = b"\x89MCAP0\r\n"
# Opcode and length, before each record.
_HEAD = struct.Struct("<BQ")
# The last record, with its head.
_FOOTER = struct.Struct("<BQQQI")
_FOOTER_CODE, _SCHEMA, _CHANNEL, _MESSAGE, _CHUNK = 0x02, 0x03, 0x04, 0x05, 0x06
_CHUNK_INDEX, _STATISTICS = 0x08, 0x0B
_MESSAGE_HEAD = struct.Struct("<HIQQ")


class McapDamaged(Exception):
    """What stands there is no such file, or not whole."""


class SchemaRecord(NamedTuple):
    """How messages of a type are read."""

    name: str
    encoding: str
    data: bytes


class ChannelRecord(NamedTuple):
    """A topic, as one recorder wrote it."""

    schema_id: int
    topic: str
    message_encoding: str
    metadata: dict[str, str]


class ChunkIndexRecord(NamedTuple):
    """Where a chunk is and what is in it; times in nanoseconds, sizes in bytes."""

    message_start_time: int
    message_end_time: int
    chunk_start_offset: int
    chunk_length: int
    message_index_offsets: dict[int, int]
    compression: str
    compressed_size: int
    uncompressed_size: int


class MessageRecord(NamedTuple):
    """A message; times in nanoseconds."""

    channel_id: int
    log_time: int
    publish_time: int
    data: bytes


class McapSummary(NamedTuple):
    """What stands at the end of a file; channels and schemas by their number."""

    schemas: dict[int, SchemaRecord]
    channels: dict[int, ChannelRecord]
    chunk_indexes: list[ChunkIndexRecord]
    message_count: int


def read_mcap_summary(stream: BinaryIO, most: int) -> McapSummary | None:
    """Read what stands at the end of a file; none: it was written without.

    Args:
        stream: the file.
        most: bytes that it may have.

    Raises:
        McapDamaged: it is no such file, or not whole.
        OSError: it cannot be read.

    """
    stream.seek(0, 2)
    size = stream.tell()
    end = size - _FOOTER.size - len(_MAGIC)
    stream.seek(0)
    if end < len(_MAGIC) or stream.read(len(_MAGIC)) != _MAGIC:
        raise McapDamaged("it does not begin as one")
    stream.seek(end)
    last = stream.read(_FOOTER.size + len(_MAGIC))
    code, _length, start, _offsets, _crc = _FOOTER.unpack_from(last)
    if code != _FOOTER_CODE or last[_FOOTER.size :] != _MAGIC:
        raise McapDamaged("it does not end as one")
    if not start:
        return None
    if not len(_MAGIC) <= start <= end:
        raise McapDamaged(f"its index is said to begin at {start} of {size} bytes")
    if end - start > most:
        raise McapDamaged(f"its index takes {end - start} bytes; {most} is the most")
    stream.seek(start)
    return _summary_of(stream.read(end - start))


def messages_of_chunk(raw: bytes, index: ChunkIndexRecord) -> Iterator[MessageRecord]:
    """Give the messages of a chunk, which must be no larger than its index says.

    Raises:
        McapDamaged: it is not whole, or another one.

    """
    code, content = next(_records_of(raw), (0, _Fields(b"")))
    if code != _CHUNK:
        raise McapDamaged("there is no chunk where its index says")
    # Its times, which the index has as well.
    content.next_bytes(16)
    size, crc = content.number("<Q"), content.number("<I")
    compression = content.text()
    packed = content.next_bytes(content.number("<Q"))
    if size != index.uncompressed_size:
        raise McapDamaged("its index does not fit to it")
    data = _unpack(compression, packed, size)
    # Writers that reckon none write 0.
    if crc and zlib.crc32(data) != crc:
        raise McapDamaged("its checksum is another one")
    for kind, record in _records_of(data):
        if kind == _MESSAGE:
            channel, _sequence, log_time, publish_time = _MESSAGE_HEAD.unpack(
                record.next_bytes(_MESSAGE_HEAD.size)
            )
            yield MessageRecord(channel, log_time, publish_time, record.rest_bytes())


def _unpack(compression: str, packed: bytes, size: int) -> bytes:
    decompress: Callable[[bytes, int], bytes]
    if not compression:
        data = packed
    elif compression in ("zstd", "lz4"):
        kind = ZstdDecompressor if compression == "zstd" else lz4.frame.LZ4FrameDecompressor
        decompress = kind().decompress
        try:
            # One byte more, so that more is seen and never unpacked.
            data = decompress(packed, size + 1)
        except Exception as error:
            # Each library has kinds of its own.
            raise McapDamaged(f"it cannot be unpacked: {error}") from error
    else:
        raise McapDamaged(f"it is packed by {compression[:40]!r}, which is not read here")
    if len(data) != size:
        raise McapDamaged(f"it has other than the {size} bytes that it says")
    return data


def _summary_of(raw: bytes) -> McapSummary:
    schemas: dict[int, SchemaRecord] = {}
    channels: dict[int, ChannelRecord] = {}
    chunks: list[ChunkIndexRecord] = []
    count = 0
    for code, fields in _records_of(raw):
        if code == _SCHEMA:
            number = fields.number("<H")
            name, encoding = fields.text(), fields.text()
            schemas[number] = SchemaRecord(name, encoding, fields.next_bytes(fields.number("<I")))
        elif code == _CHANNEL:
            number, schema = fields.number("<H"), fields.number("<H")
            topic, encoding = fields.text(), fields.text()
            channels[number] = ChannelRecord(schema, topic, encoding, fields.texts())
        elif code == _CHUNK_INDEX:
            chunks.append(_chunk_index_of(fields))
        elif code == _STATISTICS:
            count = fields.number("<Q")
    return McapSummary(schemas, channels, chunks, count)


def _chunk_index_of(fields: _Fields) -> ChunkIndexRecord:
    start, end, offset, length = (fields.number("<Q") for _ in range(4))
    pairs = fields.next_bytes(fields.number("<I"))
    if len(pairs) % 10:
        raise McapDamaged("what a chunk holds is cut off")
    offsets = dict(struct.iter_unpack("<HQ", pairs))
    # Of all indexes of messages; each is found by its offset.
    fields.number("<Q")
    compression, packed, unpacked = fields.text(), fields.number("<Q"), fields.number("<Q")
    return ChunkIndexRecord(start, end, offset, length, offsets, compression, packed, unpacked)


def _records_of(raw: bytes) -> Iterator[tuple[int, _Fields]]:
    at = 0
    while at < len(raw):
        if len(raw) - at < _HEAD.size:
            raise McapDamaged("a record is cut off")
        code, length = _HEAD.unpack_from(raw, at)
        at += _HEAD.size
        if length > len(raw) - at:
            raise McapDamaged("a record is cut off")
        yield code, _Fields(raw[at : at + length])
        at += length


class _Fields:
    """A record's fields, read one behind the other."""

    def __init__(self, raw: bytes) -> None:
        self._raw, self._at = raw, 0

    def next_bytes(self, length: int) -> bytes:
        """Give so many bytes.

        Raises:
            McapDamaged: there are fewer.

        """
        begin, self._at = self._at, self._at + length
        if self._at > len(self._raw):
            raise McapDamaged("a field is cut off")
        return self._raw[begin : self._at]

    def rest_bytes(self) -> bytes:
        """Give what is left."""
        return self._raw[self._at :]

    def number(self, form: str) -> int:
        """Give a number of one of struct's forms."""
        (value,) = struct.unpack(form, self.next_bytes(struct.calcsize(form)))
        return int(value)

    def text(self) -> str:
        """Give a text behind its length.

        Raises:
            McapDamaged: it is no UTF-8.

        """
        try:
            return self.next_bytes(self.number("<I")).decode()
        except UnicodeDecodeError as error:
            raise McapDamaged("a text is no UTF-8") from error

    def texts(self) -> dict[str, str]:
        """Give texts by their names, behind the length of all."""
        inner = _Fields(self.next_bytes(self.number("<I")))
        found: dict[str, str] = {}
        while inner._at < len(inner._raw):
            name = inner.text()
            found[name] = inner.text()
        return found
