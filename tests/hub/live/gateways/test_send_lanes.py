"""What goes down to a gateway first."""

import msgspec
import pytest

from talaia.hub.live.gateways.send_lanes import PrioritySendQueue
from talaia.wire import frames

pytestmark = pytest.mark.pure


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
