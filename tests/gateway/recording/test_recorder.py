"""Raw topics are recorded as MCAP that others read, around what happens, and reach the hub."""

from __future__ import annotations

import asyncio
import hashlib
import itertools
import os
import re
import shutil
import threading
from typing import TYPE_CHECKING

import pytest
from fake_hub import fake_hub
from gateway_bench import SITE, addresses_of, running
from hypothesis import given, settings, strategies as st
from mcap.reader import make_reader
from patience import PATIENCE_S
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from talaia.clock import HandClock
from talaia.gateway.recording import definitions
from talaia.gateway.recording.mcap_file import recover_file
from talaia.gateway.recording.message_ring import OVERHEAD, MessageRing, RawMessage
from talaia.gateway.recording.recorder import Recorder
from talaia.gateway.recording.recording_store import NoRoom, RecordingStore, StoredRecording
from talaia.gateway.recording.standing_messages import StandingMessages
from talaia.model.checks.site_checks import check_site
from talaia.model.recording import Recording, Trigger
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import FileOffer, RecorderState, RecordingRequest, StopRequest

if TYPE_CHECKING:
    from pathlib import Path

    from gateway_bench import Peer

SECOND = 1_000_000_000
STORE = get_typestore(Stores.LATEST)
NUMBER = "std_msgs/msg/Float64"


def number(value: float) -> bytes:
    return bytes(STORE.serialize_cdr(STORE.types[NUMBER](data=value), NUMBER))


class Bench:
    """A recorder with all that it tells."""

    def __init__(self, folder: Path, definition=None, **plan: object) -> None:  # noqa: D107
        self.clock = HandClock()
        self.shelf = RecordingStore(folder, 10**9, 0)
        self.shelf.open(recover_file)
        self.states: list[RecorderState] = []
        self.events: list[tuple[str, str]] = []
        self.finished = threading.Semaphore(0)
        self.recorder = Recorder(
            plan=Recording(**plan),
            topics=("/number",),
            shelf=self.shelf,
            clock=self.clock,
            definition=definition or (lambda name: definitions.definition_of(name, lambda _: {})),
            tell_state=self.states.append,
            events=self,
            finished=self.finished.release,
        )
        self.recorder.start()

    def report_event(self, kind: str, message: str, **_: object) -> None:
        self.events.append((kind, message))
        if kind == "recording_failed":
            self.finished.release()

    def offer(self, value: float, topic: str = "/number") -> None:
        self.recorder.offer(topic, NUMBER, number(value), self.clock.wall_ns())

    def wait(self) -> None:
        assert self.finished.acquire(timeout=PATIENCE_S)

    def values(self) -> list[list[float]]:
        return [numbers_in(self.shelf.whole_path(each.id)) for each in self.shelf.list_waiting()]


def numbers_in(path: Path, topic: str = "/number") -> list[float]:
    """Read a file with nothing but what is in it."""
    with AnyReader([path]) as reader:
        chosen = [each for each in reader.connections if each.topic == topic]
        return [
            reader.deserialize(data, connection.msgtype).data
            for connection, _, data in reader.messages(connections=chosen)
        ]


@settings(deadline=None)
@given(
    st.lists(st.tuples(st.integers(0, 3), st.integers(0, 900)), max_size=60),
    st.integers(0, 10),
    st.integers(1, 5_000),
)
def test_the_ring_holds_the_newest_within_its_time_and_its_bytes(steps, keep, most) -> None:
    ring, now, all_of_them = MessageRing(keep, most), 0, []
    for step, size in steps:
        now += step
        all_of_them.append(RawMessage("/t", "k", now, now, bytes(size)))
        ring.add_message(all_of_them[-1])
        assert ring.bytes <= max(most, 0)
    fitting, room = [], most
    for raw in reversed(all_of_them):
        room -= len(raw.data) + OVERHEAD
        if room < 0 or now - raw.mono_ns > keep:
            break
        fitting.insert(0, raw)
    assert list(ring.drain_messages()) == fitting
    assert (len(ring), ring.bytes) == (0, 0)


def test_a_recording_begins_with_what_was_said_long_before_and_still_holds(tmp_path) -> None:
    bench = Bench(tmp_path, before=10.0, after=5.0)
    bench.offer(1, "/tf_static")
    bench.offer(2, "/tf_static")
    for value in (3, 4):
        bench.offer(value, "/robot_description")
    said_ns = bench.clock.wall_ns()
    for value in range(30):
        bench.clock.advance(SECOND)
        bench.offer(value)
    bench.recorder.trigger_recording(Trigger.STOP, "STOP (software)", "ada")
    bench.clock.advance(6 * SECOND)
    bench.wait()
    (kept,) = bench.shelf.list_waiting()
    path = bench.shelf.whole_path(kept.id)
    # Each part of the one, of the other what it said last.
    assert numbers_in(path, "/tf_static") == [1, 2]
    assert numbers_in(path, "/robot_description") == [4]
    with path.open("rb") as stream:
        first = next(iter(make_reader(stream).iter_messages(topics=["/tf_static"])))[2]
    # At the recording's begin, with the time at which it was said.
    assert (first.log_time // 1000, first.publish_time) == (kept.begin_us, said_ns)
    # The next one has it, too.
    bench.recorder.trigger_recording(Trigger.STOP, "again", "ada")
    bench.clock.advance(6 * SECOND)
    bench.wait()
    assert numbers_in(bench.shelf.whole_path(bench.shelf.list_waiting()[-1].id), "/tf_static") == [
        1,
        2,
    ]


def test_what_still_holds_takes_a_quarter_of_the_ring_at_the_most() -> None:
    standing = StandingMessages(1000)
    for n in range(60):
        standing.remember_message(RawMessage("/tf_static", "k", n, n, bytes(50)))
    assert len(standing.messages_before(100, 100)) == 4
    standing.remember_message(RawMessage("/map", "nav_msgs/msg/OccupancyGrid", 1, 1, bytes(5000)))
    standing.remember_message(RawMessage("/odom", "nav_msgs/msg/Odometry", 1, 1, b""))
    assert {raw.topic for raw in standing.messages_before(100, 100)} == {"/tf_static"}


def test_a_cause_records_what_was_before_it_and_what_came_after(tmp_path) -> None:
    bench = Bench(tmp_path, before=10.0, after=5.0)
    for value in range(20):
        bench.offer(value)
        bench.clock.advance(SECOND)
    bench.recorder.trigger_recording(Trigger.STOP, "STOP (software)", "ada")
    bench.offer(100)
    bench.clock.advance(3 * SECOND)
    # Another cause meanwhile makes it longer, and is named.
    bench.recorder.trigger_recording(Trigger.INTERLOCK, "rain")
    bench.clock.advance(3 * SECOND)
    bench.offer(101)
    bench.clock.advance(3 * SECOND)
    bench.wait()
    (kept,) = bench.shelf.list_waiting()
    assert numbers_in(bench.shelf.whole_path(kept.id)) == [*range(10, 20), 100, 101]
    assert (kept.why, kept.who, kept.messages) == ("STOP (software); rain", "ada", 12)
    assert kept.begin_us == (1_700_000_000 + 10) * 1_000_000
    assert [state.on for state in bench.states] == [True, False]
    assert bench.states[0].id == kept.id
    # What is not wanted begins nothing.
    bench.recorder.close()
    quiet = Bench(tmp_path / "quiet", triggers=())
    quiet.recorder.trigger_recording(Trigger.STOP, "STOP")
    assert not quiet.recorder.recorder_state().on
    quiet.recorder.close()


def test_messages_with_pictures_are_not_kept_where_a_camera_is_blurred(tmp_path) -> None:
    bench = Bench(tmp_path, before=10.0)
    bench.recorder.hides_pictures = True
    bench.offer(1)
    for kind in ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"):
        bench.recorder.offer("/number", kind, b"a face", bench.clock.wall_ns())
    bench.recorder.begin_recording("ada")
    bench.recorder.offer("/number", "sensor_msgs/msg/Image", b"a face", bench.clock.wall_ns())
    bench.offer(2)
    bench.recorder.end_recording("ada")
    bench.wait()
    (kept,) = bench.shelf.list_waiting()
    assert kept.messages == 2
    assert b"a face" not in bench.shelf.whole_path(kept.id).read_bytes()
    bench.recorder.close()


def test_who_asks_may_end_it_and_the_end_of_the_gateway_finishes_it(tmp_path) -> None:
    bench = Bench(tmp_path, before=0.0, longest=60.0)
    bench.recorder.begin_recording("ada", "a test")
    bench.offer(1)
    assert bench.recorder.recorder_state().ends_ms == 60_000
    bench.recorder.end_recording("ben")
    bench.wait()
    bench.recorder.begin_recording("ada")
    bench.offer(2)
    bench.recorder.close()
    first, second = bench.shelf.list_waiting()
    assert {first.why, second.why} == {"a test", "asked for"}
    assert "ended by ben" in first.note + second.note
    assert sorted(bench.values()) == [[1.0], [2.0]]


def test_a_file_ends_at_its_size_and_the_oldest_waiting_give_way(tmp_path) -> None:
    bench = Bench(tmp_path, before=0.0, file_mb=1.0)
    bench.shelf._max_bytes = 1_200_000
    for turn in range(2):
        bench.recorder.begin_recording("ada")
        for at in range(40_000):
            bench.recorder.offer("/number", NUMBER, hashlib.sha512(b"%d" % at).digest(), at + turn)
        bench.wait()
    (kept,) = bench.shelf.list_waiting()
    assert "greatest size" in kept.note
    assert 1_000_000 < kept.size < 1_300_000
    assert [kind for kind, _ in bench.events].count("recording_dropped") == 1
    bench.recorder.close()


def test_a_disk_that_fails_is_told_and_the_next_recording_goes_well(tmp_path, monkeypatch) -> None:
    folder = tmp_path / "folder"
    bench = Bench(folder, before=0.0, after=1.0)
    folder.rmdir()
    bench.recorder.begin_recording("ada")
    bench.wait()
    assert bench.events[-1][0] == "recording_failed"
    assert "No such file" in bench.states[-1].problem
    folder.mkdir()
    bench.recorder.begin_recording("ada")
    bench.offer(3)
    bench.recorder.end_recording("ada")
    bench.wait()
    assert bench.values() == [[3.0]]
    full = shutil.disk_usage(folder)._replace(free=0)
    bench.shelf._spare = 1
    monkeypatch.setattr(shutil, "disk_usage", lambda _: full)
    with pytest.raises(NoRoom, match="has only 0 MiB left"):
        bench.shelf.begin_recording(StoredRecording(id="x", why=""), 1)
    bench.recorder.close()


def test_a_type_without_definition_does_not_spoil_the_others(tmp_path) -> None:
    def definition(name: str) -> str:
        if name != NUMBER:
            raise definitions.NoDefinition(f"nothing is known of {name}")
        return "float64 data\n"

    bench = Bench(tmp_path, definition, before=0.0)
    bench.recorder.begin_recording("ada")
    bench.recorder.offer("/odd", "odd_msgs/msg/Odd", b"", 1)
    bench.offer(4)
    bench.recorder.close()
    (kept,) = bench.shelf.list_waiting()
    assert bench.values() == [[4.0]]
    assert "without odd_msgs/msg/Odd: nothing is known" in kept.note


def test_a_recording_that_was_cut_off_is_made_whole_at_the_next_start(tmp_path) -> None:
    bench = Bench(tmp_path, before=0.0)
    bench.recorder.begin_recording("ada", "a long one")
    for value in range(20_000):
        bench.offer(float(hash(str(value))))
    bench.recorder.close()
    (kept,) = bench.shelf.list_waiting()
    body = bench.shelf.whole_path(kept.id).read_bytes()
    whole = bench.values()[0]
    lengths = []
    for cut in (len(body) // 3, len(body) * 2 // 3, len(body) - 9):
        folder = tmp_path / str(cut)
        folder.mkdir()
        (folder / f"{kept.id}.mcap.part").write_bytes(body[:cut])
        (folder / f"{kept.id}.json").write_bytes((tmp_path / f"{kept.id}.json").read_bytes())
        shelf = RecordingStore(folder, 10**9, 0)
        shelf.open(recover_file)
        (found,) = shelf.list_waiting()
        saved = numbers_in(shelf.whole_path(found.id))
        assert saved == whole[: len(saved)]
        assert "in the middle" in found.note
        assert found.why == "a long one"
        lengths.append(len(saved))
    assert 0 < lengths[0] < lengths[1] <= lengths[2] == len(whole)
    # What holds nothing is let go of, and does not keep the gateway from starting.
    (tmp_path / "x.mcap.part").write_bytes(b"noise")
    RecordingStore(tmp_path, 10**9, 0).open(recover_file)
    assert not (tmp_path / "x.mcap.part").exists()


@pytest.mark.robot
@pytest.mark.parametrize(
    "name",
    [
        "nav_msgs/msg/Odometry", "sensor_msgs/msg/Imu", "sensor_msgs/msg/BatteryState",
        "test_msgs/msg/Arrays", "test_msgs/msg/BoundedSequences", "test_msgs/msg/Strings",
        "test_msgs/msg/UnboundedSequences", "test_msgs/msg/Empty",
    ],
)  # fmt: skip
def test_a_definition_means_the_same_from_the_file_and_from_the_class(
    name, ros_domain, monkeypatch
) -> None:
    from talaia.gateway.adapters.ros2.requests import class_of

    def fields_of(wanted: str) -> dict[str, str]:
        return class_of(wanted, "a test").get_fields_and_field_types()

    hashes = set()
    for reads_files in (True, False):
        if not reads_files:
            monkeypatch.setattr(definitions, "_definition_file", lambda _: None)
        store = get_typestore(Stores.EMPTY)
        # The class no longer knows which of its bytes were called char.
        text = re.sub(r"\bchar\b", "uint8", definitions.definition_of(name, fields_of))
        store.register(get_types_from_msg(text, name))
        hashes.add(store.hash_rihs01(name))
    assert len(hashes) == 1


RECORDING = SITE + "\nrecording: {before: 30, after: 1, upload: 5000, topics: %s}\n"


@pytest.mark.robot
async def test_the_robots_messages_around_stop_reach_the_hub_as_a_file_that_others_read(
    tmp_path: Path, peer: Peer
) -> None:
    """Also a topic that no signal reads; the upload is cut, and goes on from there."""
    text = RECORDING % "[/number, /odom, /images]"
    async with (
        fake_hub(addresses_of) as hub,
        running(hub.url, tmp_path / "gateway", text) as gateway,
    ):
        await hub.until(lambda: hub.hellos, "a hello")
        await peer.until_heard_by(1)
        hub.cut_after = 1
        await peer.do("count", **{"from": 0, "to": 200, "hz": 400})
        await peer.do("odom", speed=0.25)
        recorder = gateway.recording.recorder
        assert recorder is not None
        async with asyncio.timeout(PATIENCE_S):
            while "/images" not in {raw.topic for raw in list(recorder._ring._held)}:
                await peer.do("image", encoding="rgb8")
                await asyncio.sleep(0.05)
        await hub.until(lambda: len(hub.values("base/number")) == 200, "all numbers")
        await hub.send(StopRequest(device="base", id="s1", who="ada"))
        await peer.do("count", **{"from": 200, "to": 210, "hz": 100})

        def offers() -> list[FileOffer]:
            return [each for each in hub.offers if isinstance(each, FileOffer)]

        await hub.until(offers, "an offer")
        offer = offers()[-1]
        await hub.until(lambda: len(hub.files[offer.id]) == offer.size, "the whole file")
        await hub.until(lambda: len(hub.offers) > 1, "another offer, after the cut")
        states = hub.of(RecorderState)
        assert [on for on, _ in itertools.groupby(each.on for each in states)][-2:] == [True, False]
        body = hub.files[offer.id]
        assert hashlib.sha256(body).hexdigest() == offer.digest
        assert "STOP (software) (base)" in offer.why
        assert offer.who == "ada"
        # An answer that was lost with the cut is asked for again; then the gateway forgets it.
        shelf = recorder._shelf
        await hub.until(lambda: not shelf.list_waiting(), "an empty shelf")
        # Asked for by a person.
        await hub.send(RecordingRequest(on=True, who="ben", why="to look at"))
        await hub.next(RecorderState, lambda state: state.on and state.who == "ben")
        await hub.send(RecordingRequest(on=False, who="ben"))
        await hub.until(lambda: offers()[-1].who == "ben", "another offer")
        # Asked for by an alarm at the hub: it ends by itself.
        await hub.send(RecordingRequest(on=True, who="alarm", why="alarm Low: 10 V", alarm=True))
        await hub.next(RecorderState, lambda state: state.on and state.who == "alarm")
        await hub.until(lambda: offers()[-1].who == "alarm", "the alarm's offer")
    path = tmp_path / "robot.mcap"
    path.write_bytes(body)
    assert numbers_in(path) == [float(at) for at in range(210)]
    with AnyReader([path]) as reader:
        # Every message, by the definitions that the file carries.
        decoded = [
            reader.deserialize(data, connection.msgtype)
            for connection, _, data in reader.messages()
        ]
        assert {each.topic for each in reader.connections} == {"/number", "/odom", "/images"}
    assert len(decoded) == offer.messages
    images = [each for each in decoded if each.__msgtype__ == "sensor_msgs/msg/Image"]
    assert images
    assert images[0].data.size == 48 * 64 * 3
    with path.open("rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
    assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
    odometry = next(s for s in summary.schemas.values() if s.name == "nav_msgs/msg/Odometry")
    assert b"MSG: geometry_msgs/PoseWithCovariance" in odometry.data


async def test_an_upload_goes_on_from_where_it_was_cut(tmp_path: Path) -> None:
    text = "talaia: 1\nsite: q\nname: Q\nros2: {}\ndevices: {d: {name: D}}\n"
    shelf = RecordingStore(tmp_path / "gateway" / "recordings", 10**9, 0)
    shelf.open(recover_file)
    body = os.urandom(300_000)
    shelf.whole_path("20260101T000000Z-abc").write_bytes(body)
    shelf.finish_recording(StoredRecording(id="20260101T000000Z-abc", why="a test"))
    async with fake_hub(addresses_of) as hub:
        hub.cut_after = 3
        async with running(hub.url, tmp_path / "gateway", text + "recording: {upload: 5000}"):
            await hub.until(lambda: len(hub.offers) > 1, "a second offer")
            await hub.until(lambda: not shelf.list_waiting(), "an empty shelf")
    assert hub.files == {"20260101T000000Z-abc": body}
    assert [offer.size for offer in hub.offers] == [300_000, 300_000]


def test_a_description_of_recording_is_checked() -> None:
    wrong = RECORDING % "[number]" + "\n"
    wrong = wrong.replace("after: 1,", "after: 0, file_mb: 3000,")
    said = [str(each) for each in check_site(load_site(wrong))]
    assert any("$.recording.topics[0]: 'number' is not an absolute ROS name" in s for s in said)
    assert any("$.recording.after: expected 1 to 3600 s" in s for s in said)
    assert any("$.recording.file_mb: a file of 3000 MB does not fit 2000 MB" in s for s in said)
    site = load_site(RECORDING % "[]")
    assert site.recorded_topics() == ("/number", "/odom", "/metric", "/mode", "/odd")
    assert load_site(SITE).recorded_topics() == ()
