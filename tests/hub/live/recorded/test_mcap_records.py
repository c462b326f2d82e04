"""Our reading of MCAP beside the format's own library, and of files that are none."""

from __future__ import annotations

import io
import random
from typing import TYPE_CHECKING

import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from talaia.hub.live.recorded.mcap_records import (
    McapDamaged,
    messages_of_chunk,
    read_mcap_summary,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.hub.live.recorded.mcap_records import MessageRecord

pytestmark = pytest.mark.pure
MOST = 1 << 20
CHUNK = 4096


def written_file(compression: CompressionType = CompressionType.ZSTD, **more: bool) -> bytes:
    """Write two topics of 200 messages, some of them empty."""
    stream, dice = io.BytesIO(), random.Random(4)  # noqa: S311 - made-up data
    writer = Writer(stream, chunk_size=CHUNK, compression=compression, **more)
    writer.start("ros2", library="test")
    schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data")
    channels = [
        writer.register_channel("/a", "cdr", schema, {"offered_qos_profiles": "ünï", "": "b"}),
        writer.register_channel("/b", "ros1", 0),
    ]
    for number in range(200):
        data = dice.randbytes(dice.randrange(100))
        writer.add_message(channels[number % 2], number * 10, data, number * 10 + 1, number)
    writer.finish()
    return stream.getvalue()


def read_messages(raw: bytes) -> Iterator[MessageRecord]:
    summary = read_mcap_summary(io.BytesIO(raw), MOST)
    assert summary is not None
    for index in summary.chunk_indexes:
        begin = index.chunk_start_offset
        yield from messages_of_chunk(raw[begin : begin + index.chunk_length], index)


@pytest.mark.parametrize("compression", CompressionType)
def test_a_file_is_read_as_the_formats_own_library_reads_it(compression: CompressionType) -> None:
    raw = written_file(compression)
    theirs = make_reader(io.BytesIO(raw))
    expected = theirs.get_summary()
    ours = read_mcap_summary(io.BytesIO(raw), MOST)
    assert ours is not None
    assert expected is not None
    assert expected.statistics is not None
    assert ours.message_count == expected.statistics.message_count == 200
    assert {number: found._asdict() for number, found in ours.channels.items()} == {
        number: {key: value for key, value in vars(each).items() if key != "id"}
        for number, each in expected.channels.items()
    }
    assert {number: found._asdict() for number, found in ours.schemas.items()} == {
        number: {key: value for key, value in vars(each).items() if key != "id"}
        for number, each in expected.schemas.items()
    }
    assert [found._asdict() for found in ours.chunk_indexes] == [
        {key: value for key, value in vars(each).items() if key != "message_index_length"}
        for each in expected.chunk_indexes
    ]
    assert [tuple(found) for found in read_messages(raw)] == [
        (message.channel_id, message.log_time, message.publish_time, message.data)
        for _, _, message in theirs.iter_messages()
    ]


def test_a_file_without_an_index_says_so() -> None:
    raw = written_file(
        use_chunking=False, use_statistics=False, use_summary_offsets=False,
        repeat_channels=False, repeat_schemas=False,
    )  # fmt: skip
    summary = read_mcap_summary(io.BytesIO(raw), MOST)
    assert summary is None or summary.chunk_indexes == []


def test_an_index_larger_than_is_allowed_is_not_read() -> None:
    with pytest.raises(McapDamaged, match="100 is the most"):
        read_mcap_summary(io.BytesIO(written_file()), 100)


@pytest.mark.parametrize("compression", [CompressionType.ZSTD, CompressionType.LZ4])
def test_what_unpacks_to_more_than_its_index_says_is_refused(compression: CompressionType) -> None:
    raw = written_file(compression)
    summary = read_mcap_summary(io.BytesIO(raw), MOST)
    assert summary is not None
    index = summary.chunk_indexes[0]
    begin = index.chunk_start_offset
    chunk = bytearray(raw[begin : begin + index.chunk_length])
    # Its own word on its size, behind its head and its two times.
    chunk[25:33] = (100).to_bytes(8, "little")
    small = index._replace(uncompressed_size=100)
    with pytest.raises(McapDamaged, match="other than the 100 bytes"):
        list(messages_of_chunk(bytes(chunk), small))


@pytest.mark.parametrize("seed", range(20))
def test_a_damaged_file_is_refused_in_words_or_read_and_nothing_else_happens(seed: int) -> None:
    dice, whole = random.Random(seed), written_file()  # noqa: S311 - made-up damage
    for _ in range(50):
        raw = bytearray(whole)
        for _ in range(dice.randrange(1, 4)):
            raw[dice.randrange(len(raw))] = dice.randrange(256)
        if dice.random() < 0.3:
            del raw[dice.randrange(len(raw)) :]
        try:
            found = list(read_messages(bytes(raw)))
        except (McapDamaged, AssertionError):
            continue
        assert len(found) <= 200
