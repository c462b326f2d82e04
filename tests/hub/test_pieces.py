"""The small pure parts: what is stored, what goes down first, whose clock says what."""

import msgspec
import numpy as np
from hypothesis import given, strategies as st

from talaia.hub.api.server.request_guard import host_name, same_origin
from talaia.hub.live.gateways.acknowledged_sequence import StoredRun
from talaia.hub.live.gateways.clock_offset import ClockOffset
from talaia.hub.live.gateways.send_lanes import PrioritySendQueue
from talaia.hub.live.last_values import Latest
from talaia.wire import frames
from talaia.wire.columns import Columns

spans = st.lists(st.tuples(st.integers(0, 60), st.integers(1, 12)), max_size=30)


@given(st.integers(0, 10), spans)
def test_acknowledged_is_what_lies_below_the_first_hole(below, batches) -> None:
    run = StoredRun(below)
    stored = set(range(below))
    for first, count in batches:
        run.add(first, first + count)
        stored.update(range(first, first + count))
        hole = next(number for number in range(10_000) if number not in stored)
        assert run.below == hole


def drive(session: str, seq: int) -> frames.DriveFrame:
    return frames.DriveFrame(
        device="base", session=session, epoch=1, seq=seq, tick=1, linear=0.0, angular=0.0
    )


def test_stop_overtakes_everything_and_driving_overtakes_the_rest() -> None:
    lanes = PrioritySendQueue()
    ack = frames.Ack(boot="b", below=1)
    command = frames.CommandRequest(id="1", device="base", command="go", ttl_ms=1.0, who="ada")
    stop = frames.StopRequest(device="base", id="1", who="ada")
    for message in (ack, command, drive("a", 1), stop):
        lanes.enqueue_message(message)
    taken = [lanes.next_message() for _ in range(4)]
    assert [type(each) for each in taken] == [
        frames.StopRequest,
        frames.DriveFrame,
        frames.CommandRequest,
        frames.Ack,
    ]
    assert not lanes


def test_newer_driving_frame_takes_the_place_of_an_older_one_of_its_driver() -> None:
    lanes = PrioritySendQueue()
    for message in (drive("a", 1), drive("b", 1), drive("a", 2)):
        lanes.enqueue_message(message)
    assert [lanes.next_message(), lanes.next_message()] == [drive("b", 1), drive("a", 2)]
    assert not lanes


def test_letting_go_is_not_passed_over_for_the_press_that_follows() -> None:
    lanes = PrioritySendQueue()
    for seq, linear in ((1, 0.3), (2, 0.0), (3, 0.0), (4, 0.3), (5, 0.3)):
        lanes.enqueue_message(msgspec.structs.replace(drive("a", seq), linear=linear, angular=0.0))
    waiting = [lanes.next_message(), lanes.next_message()]
    assert [(each.seq, each.linear) for each in waiting] == [(3, 0.0), (5, 0.3)]
    assert not lanes


def test_gateway_that_takes_nothing_is_found_out() -> None:
    lanes = PrioritySendQueue()
    asked = [
        lanes.enqueue_message(frames.StopRequest(device="base", id=str(at), who="ada"))
        for at in range(5000)
    ]
    assert asked[0]
    assert not asked[-1]


@given(st.lists(st.tuples(st.integers(0, 500_000), st.integers(0, 500_000)), min_size=1))
def test_offset_errs_by_no_more_than_half_of_the_quickest_loop(ways) -> None:
    true_offset, now = 7_000_000, 0
    offset = ClockOffset()
    for there, back in ways[-60:]:
        now += 1_000_000
        offset.beat(now, now + there + back, now + there + true_offset)
    best = min(there + back for there, back in ways[-60:])
    assert abs(offset.ours(now + true_offset) - now) <= best / 2 + 1


def test_without_a_beat_nothing_is_known_of_the_other_clock() -> None:
    assert ClockOffset().ours(1) is None


def test_latest_keeps_the_last_of_a_batch_and_tells_its_age() -> None:
    latest = Latest(3)
    batch = Columns(
        np.array([1, 1, 2], np.uint16), np.array([5, 6, 7]), np.array([0.1, 0.2, np.nan]), {2: "hi"}
    )
    latest.update(batch, 1_000_000_000)
    columns, ages = latest.of(np.array([2, 0, 1]), 1_500_000_000)
    assert columns.channel.tolist() == [0, 2]
    assert columns.time_us.tolist() == [7, 6]
    assert columns.value[1] == 0.2
    assert columns.texts == {0: "hi"}
    assert ages == [500.0, 500.0]


def test_remembered_sample_does_not_hide_a_live_one() -> None:
    latest = Latest(1)
    latest.remember(0, 5, 1.0, "", -1_000_000)
    columns, ages = latest.of(np.array([0]), 0)
    assert (columns.value.tolist(), ages) == ([1.0], [1.0])
    latest.update(Columns(np.zeros(1, np.uint16), np.array([9]), np.array([2.0]), {}), 10)
    latest.remember(0, 5, 1.0, "", 0)
    assert latest.of(np.array([0]), 10)[0].value.tolist() == [2.0]


def test_host_names_are_told_from_ports() -> None:
    assert [host_name(each) for each in ("Hub:8443", "hub", "[::1]:80", "[::1]")] == [
        "hub",
        "hub",
        "::1",
        "::1",
    ]


def test_only_the_very_same_origin_is_the_same() -> None:
    assert same_origin("https://hub:8443", "hub:8443", tls=True)
    for origin in ("http://hub:8443", "https://hub", "https://hub:8443/", "null", "", None):
        assert not same_origin(origin, "hub:8443", tls=True)
