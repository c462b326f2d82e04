"""A recording of any writer is read at a moment, and never more of it than is asked for."""

from __future__ import annotations

import pytest
from mcap.writer import CompressionType, IndexType, Writer

from talaia.hub.live.recorded.errors import RecordingUnreadable
from talaia.hub.live.recorded.recording_index import RecordingIndex

BEGIN_US = 1_700_000_000_000_000
SECOND_US = 1_000_000
TRANSIENT_LOCAL = "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n  deadline: 0\n"


def write_file(path, messages, *, chunk=4096, profiles=(), **options):
    """Write messages (topic, µs since the begin, bytes) as a tool of somebody else does."""
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=chunk, **options)
        writer.start("ros2", "somebody else's recorder")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data")
        channels = {}
        for topic, at_us, data in messages:
            if topic not in channels:
                told = {"offered_qos_profiles": dict(profiles).get(topic, "")}
                channels[topic] = writer.register_channel(topic, "cdr", schema, told)
            time_ns = (BEGIN_US + at_us) * 1000
            writer.add_message(channels[topic], time_ns, data, time_ns - 5000)
        writer.finish()
    return path


def a_drive(path, **options):
    """Write a minute: ticks of a kilobyte at 10 Hz, and a map that is said once."""
    ticks = [("/tick", n * 100_000, b"%04d" % n + bytes(1020)) for n in range(600)]
    messages = [*ticks[:3], ("/map", 250_000, b"the map"), *ticks[3:]]
    return write_file(path, messages, profiles={"/map": TRANSIENT_LOCAL}, **options)


def times_of(stretch, topic):
    return [
        (message.time_us - BEGIN_US) / SECOND_US
        for message in stretch.messages
        if message.topic == topic
    ]


@pytest.mark.parametrize("compression", list(CompressionType))
def test_stretch_has_its_messages_and_the_last_one_before_it(tmp_path, compression) -> None:
    index = RecordingIndex(a_drive(tmp_path / "a.mcap", compression=compression))
    stretch = index.read_stretch(
        {"/tick": 0.0, "/map": 0.0},
        BEGIN_US + 30 * SECOND_US,
        BEGIN_US + 31 * SECOND_US,
        most_bytes=1_000_000,
    )
    assert times_of(stretch, "/tick") == [29.9, *(30 + n / 10 for n in range(10))]
    assert times_of(stretch, "/map") == [0.25]
    assert stretch.until_us == BEGIN_US + 31 * SECOND_US
    found = stretch.messages[0]
    assert (found.data, found.publish_us) == (b"the map", found.time_us - 5)


def test_index_tells_topics_times_and_what_is_latched(tmp_path) -> None:
    index = RecordingIndex(a_drive(tmp_path / "a.mcap"))
    assert (index.begin_us, index.end_us) == (BEGIN_US, BEGIN_US + 59_900_000)
    assert index.count == 601
    assert index.topics["/map"].latched
    tick = index.topics["/tick"]
    assert (tick.type, tick.encoding, tick.form) == ("std_msgs/msg/String", "cdr", "ros2msg")
    assert not tick.latched


def test_what_is_too_much_at_once_is_read_on_from_where_it_ends(tmp_path) -> None:
    index = RecordingIndex(a_drive(tmp_path / "a.mcap"))
    begin, end = BEGIN_US + 10 * SECOND_US, BEGIN_US + 20 * SECOND_US
    found = []
    while begin < end:
        stretch = index.read_stretch({"/tick": 0.0}, begin, end, most_bytes=16_000)
        assert stretch.until_us > begin
        assert len(stretch.messages) < 40
        found += [message.data for message in stretch.messages if message.time_us >= begin]
        begin = stretch.until_us
    assert [int(data[:4]) for data in found] == list(range(100, 200))


def test_large_messages_come_as_often_as_is_wanted_and_light_ones_always(tmp_path) -> None:
    messages = []
    for n in range(100):
        messages += [("/cloud", n * 50_000, bytes(8000)), ("/tf", n * 50_000 + 1, b"tf")]
    index = RecordingIndex(write_file(tmp_path / "a.mcap", messages))
    stretch = index.read_stretch(
        {"/cloud": 2.0, "/tf": 2.0}, BEGIN_US, BEGIN_US + 4 * SECOND_US, most_bytes=10_000_000
    )
    assert 8 <= len(times_of(stretch, "/cloud")) <= 9
    assert len(times_of(stretch, "/tf")) == 80


def test_all_parts_of_a_latched_topic_are_there_at_any_later_moment(tmp_path) -> None:
    parts = [("/tf_static", n, b"part %d" % n) for n in range(5)]
    ticks = [("/tick", n * 100_000, bytes(1000)) for n in range(1, 300)]
    index = RecordingIndex(write_file(tmp_path / "a.mcap", [*parts, *ticks]))
    at_us = BEGIN_US + 25 * SECOND_US
    stretch = index.read_stretch({"/tf_static": 0.0}, at_us, at_us + 1, most_bytes=1000)
    assert [message.data for message in stretch.messages] == [data for _, _, data in parts]


def test_file_that_tells_no_channels_of_its_chunks_is_read_all_the_same(tmp_path) -> None:
    index = RecordingIndex(a_drive(tmp_path / "a.mcap", index_types=IndexType.CHUNK))
    at_us = BEGIN_US + 30 * SECOND_US
    stretch = index.read_stretch({"/tick": 0.0}, at_us, at_us + 1, most_bytes=1000)
    assert times_of(stretch, "/tick") == [29.9, 30.0]


def test_type_of_ros1_has_the_name_that_pages_know(tmp_path) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros1")
        schema = writer.register_schema("std_msgs/String", "ros1msg", b"string data")
        channel = writer.register_channel("/said", "ros1", schema, {"latching": "1"})
        writer.add_message(channel, BEGIN_US * 1000, b"\2\0\0\0hi", 0)
        json = writer.register_channel("/json", "json", schema)
        writer.add_message(json, BEGIN_US * 1000, b"{}", 0)
        writer.finish()
    topics = RecordingIndex(path).topics
    assert (topics["/said"].type, topics["/said"].latched) == ("std_msgs/msg/String", True)
    assert "json" in topics["/json"].problem


@pytest.mark.parametrize(
    ("bytes_of", "why"),
    [
        (lambda _: b"", "no whole MCAP"),
        (lambda _: b"this is a text, and none of that kind", "no whole MCAP"),
        (lambda whole: whole[: len(whole) // 2], "no whole MCAP"),
    ],
)
def test_file_that_is_none_or_cut_off_says_so(tmp_path, bytes_of, why) -> None:
    path = a_drive(tmp_path / "a.mcap")
    path.write_bytes(bytes_of(path.read_bytes()))
    with pytest.raises(RecordingUnreadable, match=why):
        RecordingIndex(path)


def test_file_without_an_index_says_how_to_make_one(tmp_path) -> None:
    path = a_drive(tmp_path / "a.mcap", use_chunking=False)
    with pytest.raises(RecordingUnreadable, match="mcap recover"):
        RecordingIndex(path)


def test_damaged_chunk_is_told_and_raises_nothing_else(tmp_path) -> None:
    path = a_drive(tmp_path / "a.mcap", compression=CompressionType.NONE)
    data = bytearray(path.read_bytes())
    data[20_000:20_100] = b"\xff" * 100
    path.write_bytes(bytes(data))
    index = RecordingIndex(path)
    with pytest.raises(RecordingUnreadable, match="damaged"):
        index.read_stretch(
            {"/tick": 0.0}, BEGIN_US, BEGIN_US + 10 * SECOND_US, most_bytes=1_000_000
        )
