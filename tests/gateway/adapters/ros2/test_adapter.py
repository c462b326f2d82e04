"""The gateway between a real ROS 2 robot and a hub."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from itertools import count
from typing import TYPE_CHECKING

import pytest
import simplejpeg
from fake_hub import FakeHub, fake_hub
from gateway_bench import SITE, Peer, addresses_of, command, drive, filled, running, take_lease
from patience import PATIENCE_S, lasts_for, stays

from talaia.wire.frames import (
    CommandCancel,
    CommandPhase,
    CommandRequest,
    CommandState,
    DriveState,
    Event,
    InterlockState,
    ReconnectRequest,
    ResetRequest,
    ResetToken,
    StopRequest,
    StopState,
    StreamSubscription,
)

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

pytestmark = pytest.mark.robot
STAMPED = (
    SITE.replace(
        "field: twist.twist.linear.x}", "field: twist.twist.linear.x, stamp: header.stamp}"
    )
    + """
interlocks:
  fast:
    name: Fast
    when: [{signal: base/speed, above: 5}]
    refuse: [base/wander]
    dwell: 0
"""
)


@asynccontextmanager
async def linked(tmp_path: Path) -> AsyncIterator[FakeHub]:
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path):
        await hub.until(lambda: hub.hellos, "a hello")
        yield hub


@pytest.fixture
async def hub(peer: Peer, tmp_path: Path) -> AsyncIterator[FakeHub]:
    async with linked(tmp_path) as one:
        await peer.until_heard_by(1)
        yield one


async def test_samples_reach_the_hub_once_each_across_lost_links(hub: FakeHub, peer: Peer) -> None:
    await peer.do("count", **{"from": 0, "to": 600, "hz": 300})
    for cut in (1, 2):
        await hub.until(lambda cut=cut: len(hub.values("base/number")) > cut * 100, "samples")
        hub.acking = not hub.acking
        hub.cut()
        await hub.until(lambda cut=cut: len(hub.hellos) > cut, "a new link")
    await peer.until(lambda: peer.heard("counted"))
    await hub.until(lambda: len(hub.values("base/number")) >= 600, "the rest")
    assert hub.values("base/number") == [float(each) for each in range(600)]
    assert hub.old_batches > 0


async def test_every_kind_of_signal_arrives(hub: FakeHub, peer: Peer) -> None:
    # Each is published once, and not kept for who subscribes later.
    for publisher in ("metric", "odom"):
        await peer.until_heard_by(1, of=publisher)
    await peer.do("mode", text="auto ✓")
    await peer.do("metric", text="{'name': 'speed1', 'magnitude': 1.4}")
    await peer.do("metric", text='{"name": "other9", "magnitude": 3}')
    await hub.until(lambda: hub.values("base/speed1") and hub.values("base/mode"), "values")
    await peer.do("odom", speed=0.25)
    await hub.until(lambda: hub.values("base/pose.yaw"), "a pose")
    assert hub.values("base/speed1") == [1.4]
    assert hub.values("base/mode") == ["auto ✓"]
    assert hub.values("base/speed") == [0.25]
    assert hub.values("base/pose.x") == [1.5]
    assert hub.values("base/pose.yaw") == [0.0]


async def test_a_parameter_is_read_and_set(hub: FakeHub, peer: Peer) -> None:
    await hub.until(lambda: 1.5 in hub.values("base/gain"), "the parameter")
    assert (await command(hub, "tune", "t1", gain=2.5)).phase is CommandPhase.SUCCEEDED
    await hub.until(lambda: 2.5 in hub.values("base/gain"), "the new value")


async def test_a_command_whose_type_is_not_installed_is_named_and_the_rest_runs(
    peer: Peer, tmp_path: Path
) -> None:
    text = SITE.replace(
        "type: std_srvs/srv/Trigger}\n      count", "type: nowhere_msgs/srv/Odd}\n      count"
    )
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path, text):
        event = await hub.next(Event, lambda each: each.kind == "type_missing")
        assert "/absent" in event.message
        assert "nowhere_msgs/srv/Odd" in event.message
        await peer.until_heard_by(1)
        await peer.do("count", **{"from": 0, "to": 3, "hz": 100})
        await hub.until(lambda: len(hub.values("base/number")) == 3, "numbers")


async def test_drive_frame_becomes_cmd_vel_then_zeros_then_silence(
    hub: FakeHub, peer: Peer
) -> None:
    epoch = await take_lease(hub)
    took = []
    for _ in range(10):
        before = len(peer.heard("cmd"))
        sent = await drive(hub, epoch)
        await peer.until(lambda before=before: len(peer.heard("cmd")) > before)
        took.append((peer.rows[-1]["at"] - sent) / 1e6)
        await asyncio.sleep(0.05)
    last_moving = max(row["at"] for row in peer.rows if row.get("cmd", [0])[0] > 0)
    assert max(row[0] for row in peer.heard("cmd")) <= 0.2
    state = await hub.next(DriveState, lambda each: each.linear > 0.1)
    assert state.cap == 1.0
    await hub.next(DriveState, lambda each: each.linear == 0)
    await hub.next(Event, lambda each: each.kind == "drive_ended")
    # The zeros, and then silence for as long as they would have gone on.
    await lasts_for(1.6)
    zeros = [row["at"] for row in peer.rows if row.get("cmd") == [0.0, 0.0]]
    # Twenty a second for one second; on a machine that others use a few of them are heard late, the
    # first one as well.
    assert len(zeros) >= 15
    assert 0.8e9 <= zeros[-1] - zeros[0] <= 1.3e9
    assert zeros[0] - last_moving <= 350e6
    assert peer.rows[-1]["at"] - zeros[-1] <= 0
    assert sorted(took)[len(took) // 2] < 60


async def test_lost_link_stops_the_robot_and_needs_a_new_lease(hub: FakeHub, peer: Peer) -> None:
    epoch = await take_lease(hub)
    await drive(hub, epoch)
    await peer.until(lambda: any(row[0] > 0 for row in peer.heard("cmd")))
    hub.cut()
    await peer.until(lambda: peer.heard("cmd")[-1] == [0.0, 0.0])
    await hub.until(lambda: len(hub.hellos) == 2, "a new link")
    await drive(hub, epoch)
    state = await hub.next(DriveState, lambda each: each.refused > 0)
    assert state.linear == 0
    assert peer.heard("cmd")[-1] == [0.0, 0.0]


async def test_a_gateway_that_ends_while_somebody_drives_leaves_the_robot_at_rest(
    peer: Peer, tmp_path: Path
) -> None:
    async with linked(tmp_path) as hub:
        await peer.until_heard_by(1)
        epoch = await take_lease(hub)
        await drive(hub, epoch)
        await peer.until(lambda: any(row[0] > 0 for row in peer.heard("cmd")))
    await peer.until(lambda: peer.heard("cmd")[-1] == [0.0, 0.0])


async def test_stop_latches_over_a_restart_and_is_reset_in_two_steps(
    peer: Peer, tmp_path: Path
) -> None:
    async with linked(tmp_path) as hub:
        await peer.until_heard_by(1)
        await hub.send(StopRequest(device="base", id="s1", who="Ada"))
        assert (await hub.next(StopState, lambda each: each.id == "s1")).latched
        await peer.until(lambda: True in peer.heard("stop"))
        # Another topic: it may come a little later, and the first zero before its discovery.
        await peer.until(lambda: peer.heard("cmd"))
        assert peer.heard("cmd")[-1] == [0.0, 0.0]
        for _ in range(3):
            await peer.do("odom", speed=0.0)
            await asyncio.sleep(0.05)
        await hub.next(StopState, lambda each: each.confirmed)
    peer.rows.clear()
    async with linked(tmp_path) as hub:
        assert (await hub.next(StopState)).latched
        await peer.until(lambda: True in peer.heard("stop"))
        epoch = await take_lease(hub)
        await drive(hub, epoch)
        assert (await hub.next(DriveState, lambda each: bool(each.why))).why == "STOP is on"
        ask = {"device": "base", "session": "tab", "epoch": epoch, "who": "Ada"}
        await hub.send(ResetRequest(**ask))
        token = (await hub.next(ResetToken)).token
        await hub.send(ResetRequest(**ask, token=token))
        assert not (await hub.next(StopState, lambda each: not each.latched)).latched
        await peer.until(lambda: peer.heard("stop")[-1] is False)
        assert all(row == [0.0, 0.0] for row in peer.heard("cmd"))


async def test_commands_end_as_the_robot_says(hub: FakeHub, peer: Peer) -> None:
    done = await command(hub, "wander", "w1", active=True)
    assert (done.phase, done.message) == (CommandPhase.SUCCEEDED, "wandering")
    failed = await command(hub, "fail", "f1")
    assert (failed.phase, failed.message) == (CommandPhase.FAILED, "the wheel is off")
    absent = await command(hub, "absent", "a1")
    assert absent.phase is CommandPhase.REFUSED
    assert "/absent" in absent.message
    assert (await command(hub, "wander", "w2", active="yes")).phase is CommandPhase.REFUSED
    assert (await command(hub, "wander", "w3")).phase is CommandPhase.REFUSED
    assert (await command(hub, "horn", "h1", tune="la")).phase is CommandPhase.SUCCEEDED
    await peer.until(lambda: peer.heard("horn") == ["la"])
    assert peer.heard("wander") == [True]


def states(hub: FakeHub, command_id: str) -> list[CommandState]:
    return [x for x in hub.messages if isinstance(x, CommandState) and x.id == command_id]


async def until_ended(hub: FakeHub, command_id: str) -> list[CommandState]:
    under_way = {CommandPhase.ACCEPTED, CommandPhase.RUNNING}
    await hub.until(
        lambda: [x for x in states(hub, command_id) if x.phase not in under_way], "its end"
    )
    return states(hub, command_id)


async def test_an_action_tells_its_progress_and_its_end(hub: FakeHub, peer: Peer) -> None:
    args = {"order": 10}
    await hub.send(
        CommandRequest(id="c1", device="base", command="count", args=args, ttl_ms=5000, who="Ada")
    )
    said = await until_ended(hub, "c1")
    assert (said[-1].phase, said[-1].progress) == (CommandPhase.SUCCEEDED, 1.0)
    assert peer.heard("goal") == [10]
    shares = [x.progress for x in said if x.phase is CommandPhase.RUNNING]
    assert shares == sorted(shares)
    assert any(0.0 < share < 1.0 for share in shares)
    # Ten feedbacks in a second; at most five of them are told.
    assert len(shares) <= 8


async def test_an_action_ends_as_the_robot_says(hub: FakeHub, peer: Peer) -> None:
    refused = await command(hub, "count", "c2", order=0)
    assert (refused.phase, refused.message) == (
        CommandPhase.REFUSED,
        "the robot does not accept it",
    )
    assert (await command(hub, "count", "c3", order=13)).phase is CommandPhase.FAILED
    missing = await command(hub, "missing", "c4")
    assert missing.phase is CommandPhase.REFUSED
    assert "does not offer /nowhere" in missing.message
    assert peer.heard("goal") == [13]


async def test_an_action_is_cancelled_by_the_robot_and_told_so(hub: FakeHub, peer: Peer) -> None:
    ask = CommandRequest(
        id="c5", device="base", command="count", args={"order": 50}, ttl_ms=5000, who="Ada"
    )
    await hub.send(ask)
    await peer.until(lambda: peer.heard("goal"))
    await hub.send(CommandCancel(id="c5", device="base", who="Ben"))
    said = await until_ended(hub, "c5")
    assert said[-1].phase is CommandPhase.CANCELLED
    assert peer.heard("cancelled") == [50]
    assert any("Ben asked to cancel" in x.message for x in said)


async def test_a_command_asked_in_another_unit_is_refused(hub: FakeHub, peer: Peer) -> None:
    ask = CommandRequest(
        id="c6", device="base", command="count", args={"order": 1}, units={"order": "min"},
        ttl_ms=5000, who="Ada",
    )  # fmt: skip
    await hub.send(ask)
    ended = await hub.next(CommandState, lambda x: x.id == "c6" and x.phase == "refused")
    assert "asked in min, but it is s here" in ended.message
    assert peer.heard("goal") == []


async def test_command_id_acts_once_even_across_a_restart(peer: Peer, tmp_path: Path) -> None:
    for _ in range(2):
        async with linked(tmp_path) as hub:
            await peer.until_heard_by(1)
            for _ in range(2):
                done = await command(hub, "wander", "only", active=True)
                assert done.phase is CommandPhase.SUCCEEDED
    assert peer.heard("wander") == [True]


async def test_pictures_come_only_while_somebody_looks(hub: FakeHub, peer: Peer) -> None:
    async def show(encoding: str) -> None:
        before = len(hub.pictures)
        async with asyncio.timeout(PATIENCE_S):
            while len(hub.pictures) == before:
                await peer.do("image", encoding=encoding)
                await asyncio.sleep(0.05)

    for _ in range(5):
        await peer.do("image", encoding="rgb8")
    await stays(0.3, lambda: hub.pictures == [], "no picture goes to a hub that asked for none")
    await hub.send(StreamSubscription(streams=["base/front"]))
    await show("rgb8")
    picture = hub.pictures[-1]
    assert (picture.stream, picture.width, picture.height) == ("base/front", 64, 48)
    red, green, blue = simplejpeg.decode_jpeg(picture.data)[24, 32]
    assert red > 200
    assert max(green, blue) < 60
    await show("mono8")
    await peer.do("image", encoding="yuv9")
    event = await hub.next(Event, lambda each: each.kind == "unreadable")
    assert "yuv9" in event.message


async def test_device_that_is_connected_anew_says_what_is_not_there_and_works_on(
    hub: FakeHub, peer: Peer
) -> None:
    await hub.send(ReconnectRequest(device="base", who="Ada"))
    told = await hub.next(Event, lambda each: each.kind.startswith("device "))
    assert (told.kind, told.device, told.who, told.good) == (
        "device not reconnected", "base", "Ada", False
    )  # fmt: skip
    assert "9 of 12" in told.message
    assert "/odd (nobody publishes it)" in told.message
    assert "/absent (no such service now)" in told.message
    assert "/nowhere (no such action now)" in told.message
    await peer.until_heard_by(1)
    await peer.do("count", **{"from": 0, "to": 50, "hz": 500})
    await hub.until(lambda: len(hub.values("base/number")) >= 50, "samples")
    assert (await command(hub, "wander", "after", active=True)).phase is CommandPhase.SUCCEEDED


async def test_reconnecting_a_device_leaves_driving_alone(hub: FakeHub, peer: Peer) -> None:
    epoch = await take_lease(hub)
    await drive(hub, epoch)
    await peer.until(lambda: any(row[0] > 0 for row in peer.heard("cmd")))
    await hub.send(ReconnectRequest(device="base", who="Ada"))
    heard = len(peer.heard("cmd"))
    await drive(hub, epoch, 0.1)
    await peer.until(lambda: any(row[0] == 0.1 for row in peer.heard("cmd")[heard:]))
    state = await hub.next(DriveState, lambda each: each.linear == 0.1)
    assert state.device == "base"


async def test_device_with_all_of_it_there_is_connected_anew(peer: Peer, tmp_path: Path) -> None:
    text = filled("""
talaia: 1
site: test
name: Test robot
ros2: {}
devices:
  base:
    name: Base
    signals:
      <number>
    commands:
      <wander>
  spare: {name: Spare}
""")
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path, text):
        await hub.until(lambda: hub.hellos, "a hello")
        await peer.until_heard_by(1)
        for device, said in (
            ("base", "2 of 2 topics and services are there"),
            ("spare", "it has nothing on the robot to connect to"),
        ):
            await hub.send(ReconnectRequest(device=device, who="Ada"))
            told = await hub.next(Event, lambda each: each.kind.startswith("device "))
            assert (told.kind, told.message, told.good) == ("device reconnected", said, True)
        await hub.send(ReconnectRequest(device="cellar", who="Ada"))
        told = await hub.next(Event, lambda each: each.kind.startswith("device "))
        assert (told.good, told.message) == (False, "there is no such device at the robot now")


async def test_site_without_a_robot_says_so_when_asked_to_reconnect(tmp_path: Path) -> None:
    text = "talaia: 1\nsite: q\nname: Q\ndevices: {d: {name: D}}"
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path, text):
        await hub.until(lambda: hub.hellos, "a hello")
        await hub.send(ReconnectRequest(device="d", who="Ada"))
        told = await hub.next(Event)
        assert (told.good, told.message) == (False, "this site has no robot connection")


async def test_a_stamp_that_stands_still_while_messages_arrive_is_unknown(
    peer: Peer, tmp_path: Path
) -> None:
    stamps = count(1)
    newest = 0

    async def send(*, stands: bool) -> None:
        nonlocal newest
        while True:
            newest = newest if stands else next(stamps)
            await peer.do("odom", speed=0.1 + newest % 2, stamp=newest)
            await asyncio.sleep(0.1)

    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path, STAMPED):
        for stands in (False, True, False):
            sending = asyncio.ensure_future(send(stands=stands))
            told = await hub.next(
                InterlockState,
                lambda each, stands=stands: (
                    "stood still" in each.why if stands else not each.locked
                ),
            )
            assert told.locked is stands
            sending.cancel()
