"""Control: lease, driving and STOP together, as the hub's messages come."""

from __future__ import annotations

import math
from itertools import count
from typing import TYPE_CHECKING

import pytest

from talaia.clock import MS, SECOND, HandClock
from talaia.gateway.driving.drive_service import DriveService
from talaia.gateway.driving.persistent_state import LeaseEpochs, PersistentStops
from talaia.gateway.driving.stop_writer import StopWriter
from talaia.gateway.driving.tick_clock import TickClock
from talaia.gateway.ports import ChannelReading
from talaia.gateway.velocity_demand import VelocityDemand
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import (
    ControlTick,
    DriveFrame,
    DriveState,
    LeaseOp,
    LeaseRequest,
    LeaseState,
    ResetRequest,
    ResetToken,
    StopRequest,
    StopState,
)

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.pure

SITE = load_site(
    """
talaia: 1
site: s
name: S
ros2: {}
devices:
  base:
    name: Base
    signals:
      v: {name: V, source: {topic: /odom, type: nav_msgs/msg/Odometry, field: twist.twist.linear.x}}
    drive:
      {topic: /cmd_vel, max_speed: 0.2, max_turn: 2, stop: {topic: /stop, confirmed_by: [base/v]}}
"""
)


class Robot:
    """What the gateway says, each with its time, and what the robot reads."""

    def __init__(self, clock: HandClock) -> None:  # noqa: D107
        self.clock = clock
        self.driven: list[tuple[int, float, float]] = []
        self.stopped: list[bool] = []
        self.sent: list[object] = []
        self.notes: list[str] = []
        self.speed: ChannelReading | None = None

    def drive(self, device: str, demand: VelocityDemand) -> None:
        assert device == "base"
        self.driven.append((self.clock.monotonic_ns(), demand.linear, demand.angular))

    def stop(self, device: str, *, stopped: bool) -> None:
        assert device == "base"
        self.stopped.append(stopped)

    def send(self, message: object) -> None:
        self.sent.append(message)

    def record_event(self, kind: str, device: str, message: str, who: str, *, good: bool) -> None:
        self.notes.append(kind)

    def latest(self, address: str) -> ChannelReading | None:
        assert address == "base/v"
        return self.speed

    def last(self, kind: type) -> object:
        return [each for each in self.sent if isinstance(each, kind)][-1]


class Bench:
    """A control, its robot and its clock."""

    site = SITE
    robot_kind = Robot

    def __init__(self, folder: Path) -> None:  # noqa: D107
        self.clock = HandClock(monotonic_ns=100 * SECOND)
        self.robot = self.robot_kind(self.clock)
        self.folder = folder
        self.seq = count()
        self.control = self.build()
        self.control.link_up()

    def build(self) -> DriveService:
        async def on_disk(work) -> None:
            work()

        return DriveService(
            site=self.site,
            clock=self.clock,
            output=self.robot,
            readings=self.robot,
            next_epoch=LeaseEpochs(self.folder / "epochs.json").next_epoch,
            stops=StopWriter(
                stops=PersistentStops(self.folder / "stops.json"),
                on_disk=on_disk,
                output=self.robot,
            ),
        )

    def lease(self, session: str = "tab", op: LeaseOp = LeaseOp.TAKE) -> LeaseState:
        self.control.handle_lease(LeaseRequest(device="base", session=session, who=session, op=op))
        return self.robot.last(LeaseState)

    def drive(self, linear: float = 0.1, session: str = "tab", epoch: int | None = None) -> None:
        held = self.control.controllers["base"].lease.holder_at(self.clock.monotonic_ns())
        self.control.handle_frame(
            DriveFrame(
                device="base",
                session=session,
                epoch=(held.epoch if held else 0) if epoch is None else epoch,
                seq=next(self.seq),
                tick=max(0, self.control.ticks.last),
                linear=linear,
                angular=0.0,
            )
        )

    def pass_time(self, ns: int) -> None:
        """Let time pass, with `step` called exactly when it is due."""
        end = self.clock.monotonic_ns() + ns
        while True:
            due = self.control.due_ns()
            now = self.clock.monotonic_ns()
            if due is None or due > end:
                self.clock.advance(end - now)
                return
            self.clock.advance(max(0, due - now))
            self.control.run_due()


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    return Bench(tmp_path)


KEYS_SITE = load_site(
    """
talaia: 1
site: s
name: S
ros2: {}
devices:
  base:
    name: Base
    signals:
      v: {name: V, source: {topic: /speed, type: std_msgs/msg/Float64, field: data}}
    drive: {topic: /control, message: std_msgs/msg/String, max_speed: 0.5, max_turn: 1}
"""
)


class KeyRobot(Robot):
    """A robot that listens to characters."""

    heard = ""

    def drive(self, device: str, demand: VelocityDemand, key: str = "") -> None:
        self.driven.append((self.clock.monotonic_ns(), demand.linear, demand.angular))
        self.heard += key


class KeyBench(Bench):
    """A control of such a robot."""

    site = KEYS_SITE
    robot_kind = KeyRobot


def test_a_key_held_for_a_second_is_one_character_and_its_end_is_s(tmp_path: Path) -> None:
    """The founding robot adds 0.1 for each: 20 characters a second were 2.5 rad/s in a moment."""
    bench = KeyBench(tmp_path)
    bench.pass_time(20 * SECOND)
    bench.robot.heard = ""
    bench.lease()
    for _ in range(24):
        bench.drive(0.5)
        bench.pass_time(50 * MS)
    assert bench.robot.heard == "w"
    told = bench.robot.last(DriveState)
    assert told.sent == "w"
    assert math.isnan(told.linear)
    bench.pass_time(2 * SECOND)
    assert set(bench.robot.heard[1:]) == {"s"}
    bench.lease(op=LeaseOp.FREE)
    assert bench.robot.last(DriveState).linear == 0.0


def test_a_robot_that_keeps_its_velocity_is_halted_at_the_start_and_when_it_is_there_again(
    tmp_path: Path,
) -> None:
    bench = KeyBench(tmp_path)
    bench.pass_time(20 * SECOND)
    assert set(bench.robot.heard) == {"s"}
    bench.robot.heard = ""
    bench.pass_time(SECOND)
    assert bench.robot.heard == ""
    bench.control.robot_lost(["base"])
    bench.control.robot_back(["base"])
    bench.pass_time(2 * SECOND)
    assert set(bench.robot.heard) == {"s"}


def test_stop_says_s_to_a_robot_that_is_driven_by_characters(tmp_path: Path) -> None:
    bench = KeyBench(tmp_path)
    bench.lease()
    bench.drive(0.5)
    bench.control.stop_device(StopRequest(device="base", id="1", who="ann"))
    assert bench.robot.heard[-1] == "s"


def test_accepted_frame_is_published_inside_the_call(bench: Bench) -> None:
    bench.lease()
    bench.drive()
    assert bench.robot.driven[0][0] == bench.clock.monotonic_ns()
    assert bench.robot.driven[0][1] > 0


def test_ticks_come_at_twenty_hertz_only_while_a_lease_is_held(bench: Bench) -> None:
    bench.pass_time(SECOND)
    assert not any(isinstance(each, ControlTick) for each in bench.robot.sent)
    bench.lease()
    bench.pass_time(SECOND)
    assert 20 <= sum(isinstance(each, ControlTick) for each in bench.robot.sent) <= 21
    bench.lease(op=LeaseOp.FREE)
    bench.robot.sent.clear()
    bench.pass_time(SECOND)
    assert bench.robot.sent == []
    assert bench.control.due_ns() is None


def test_frame_that_echoes_an_old_tick_is_refused(bench: Bench) -> None:
    bench.lease()
    bench.clock.advance(300 * MS)
    bench.drive()
    assert bench.robot.driven == []
    assert "too old" in bench.robot.last(DriveState).why


def test_lost_driver_means_zeros_within_the_ttl_then_silence(bench: Bench) -> None:
    bench.lease()
    bench.drive()
    began = bench.clock.monotonic_ns()
    bench.pass_time(2900 * MS)
    zeros = [at - began for at, linear, _ in bench.robot.driven if linear == 0]
    assert zeros[0] == 250 * MS
    assert 1200 * MS <= zeros[-1] <= 1250 * MS
    assert {linear for at, linear, _ in bench.robot.driven if at - began >= 250 * MS} == {0.0}


def test_link_loss_frees_the_lease_and_stops_at_once(bench: Bench) -> None:
    bench.lease()
    bench.drive()
    bench.control.link_lost()
    assert bench.robot.driven[-1][1:] == (0.0, 0.0)
    bench.control.link_up()
    assert bench.robot.last(LeaseState).session == ""
    bench.drive()
    assert bench.robot.driven[-1][1:] == (0.0, 0.0)


def test_frames_of_an_earlier_lease_move_nothing(bench: Bench) -> None:
    old = bench.lease().epoch
    bench.lease(op=LeaseOp.FREE)
    assert bench.lease().epoch > old
    bench.drive(epoch=old)
    assert all(linear == 0 for _, linear, _ in bench.robot.driven)


def test_other_session_is_refused_and_told_who_drives(bench: Bench) -> None:
    bench.lease()
    refused = bench.lease("other")
    assert (refused.session, refused.asked, refused.refused) == ("tab", "other", "tab is driving")
    bench.drive(session="other")
    assert bench.robot.driven == []


def test_refusals_are_written_down_once_for_a_hold(bench: Bench) -> None:
    bench.lease()
    for _ in range(20):
        bench.drive(epoch=999)
    assert bench.robot.notes.count("drive_refused") == 1
    assert bench.control.controllers["base"].driving.refused == 20


def test_lease_that_is_not_renewed_ends_with_zeros_and_is_told(bench: Bench) -> None:
    bench.lease()
    for _ in range(29):
        bench.drive()
        bench.pass_time(100 * MS)
    bench.drive()
    bench.pass_time(100 * MS)
    assert bench.robot.last(LeaseState).session == ""
    assert bench.robot.driven[-1][1] == 0
    assert "lease_ended" in bench.robot.notes
    assert "drive_ended" in bench.robot.notes


def test_stop_zeroes_latches_and_is_repeated_to_the_robot(bench: Bench) -> None:
    bench.lease()
    bench.drive()
    assert bench.control.stop_device(StopRequest(device="base", id="i", who="Ben")) is not None
    assert bench.robot.driven[-1][1:] == (0.0, 0.0)
    assert bench.robot.stopped == [True]
    assert bench.robot.last(StopState).id == "i"
    bench.drive()
    assert bench.robot.driven[-1][1:] == (0.0, 0.0)
    bench.pass_time(SECOND)
    early = len(bench.robot.stopped)
    assert 19 <= early <= 22
    bench.pass_time(5 * SECOND)
    assert 4 <= len(bench.robot.stopped) - early <= 6


def test_repeated_stop_is_answered_each_time(bench: Bench) -> None:
    for number in range(3):
        bench.control.stop_device(StopRequest(device="base", id="same", who="Ben"))
        answers = [each for each in bench.robot.sent if isinstance(each, StopState)]
        assert sum(each.id == "same" for each in answers) == number + 1
    assert bench.robot.notes.count("stop") == 1


def test_stop_is_confirmed_by_the_robot_itself(bench: Bench) -> None:
    bench.control.stop_device(StopRequest(device="base", id="i", who="Ben"))
    bench.robot.speed = ChannelReading(0.1, bench.clock.monotonic_ns())
    bench.pass_time(100 * MS)
    assert not bench.robot.last(StopState).confirmed
    bench.robot.speed = ChannelReading(0.001, bench.clock.monotonic_ns())
    bench.pass_time(100 * MS)
    assert bench.robot.last(StopState).confirmed


async def test_stop_survives_a_restart_and_nobody_holds_a_lease_after_it(bench: Bench) -> None:
    first = bench.lease().epoch
    latched = bench.control.stop_device(StopRequest(device="base", id="i", who="Ben"))
    await bench.control.keep_stop("base", latched)
    bench.robot.sent.clear()
    bench.control = bench.build()
    bench.control.link_up()
    assert bench.robot.last(StopState).latched
    assert bench.robot.last(LeaseState).session == ""
    bench.drive(epoch=first)
    assert bench.robot.driven[-1][1:] == (0.0, 0.0)
    assert bench.lease().epoch > first


async def test_reset_needs_lease_and_token_and_starts_no_motion(bench: Bench) -> None:
    latched = bench.control.stop_device(StopRequest(device="base", id="i", who="Ben"))
    await bench.control.keep_stop("base", latched)
    ask = {"device": "base", "session": "tab", "who": "Ada"}
    await bench.control.reset_stop(ResetRequest(**ask, epoch=0))
    assert bench.robot.last(ResetToken).refused
    epoch = bench.lease().epoch
    await bench.control.reset_stop(ResetRequest(**ask, epoch=epoch, token="guess"))  # noqa: S106
    assert bench.robot.last(ResetToken).refused
    await bench.control.reset_stop(ResetRequest(**ask, epoch=epoch))
    token = bench.robot.last(ResetToken).token
    assert token
    bench.drive()
    bench.clock.advance(50 * MS)
    await bench.control.reset_stop(ResetRequest(**ask, epoch=epoch, token=token))
    assert not bench.robot.last(StopState).latched
    assert bench.robot.stopped[-1] is False
    # The driver still holds the key down: nothing moves until it was let go.
    for _ in range(10):
        bench.drive()
        bench.pass_time(50 * MS)
    assert bench.robot.driven[-1][1] == 0
    bench.drive(linear=0.0)
    bench.pass_time(50 * MS)
    bench.drive()
    bench.pass_time(50 * MS)
    assert bench.robot.driven[-1][1] > 0
    assert PersistentStops(bench.folder / "stops.json").find_stop("base") is None


def test_ticks_that_were_never_sent_have_no_age() -> None:
    ticks = TickClock()
    assert ticks.age_ns(0, 0) < 0
    for number in range(100):
        ticks.next_tick(number)
    assert ticks.age_ns(99, 100) == 1
    assert ticks.age_ns(100, 100) < 0
    assert ticks.age_ns(0, 100) > SECOND


def test_letting_go_and_pressing_anew_moves_nothing_while_stopped(bench: Bench) -> None:
    bench.lease()
    bench.control.stop_device(StopRequest(device="base", id="i", who="Ben"))
    for linear in (0.0, 0.1, 0.1):
        bench.drive(linear)
        bench.pass_time(100 * MS)
    assert bench.robot.last(DriveState).why == "STOP is on"
    assert {linear for _, linear, _ in bench.robot.driven} == {0.0}


async def test_reset_under_an_earlier_epoch_is_refused(bench: Bench) -> None:
    bench.control.stop_device(StopRequest(device="base", id="i", who="Ben"))
    old = bench.lease().epoch
    bench.lease()
    await bench.control.reset_stop(ResetRequest(device="base", session="tab", who="Ada", epoch=old))
    assert bench.robot.last(ResetToken).refused


def test_lease_is_refused_while_no_epoch_can_be_kept(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full() -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(bench.control.controllers["base"].lease, "_next_epoch", full)
    state = bench.lease()
    assert state.session == ""
    assert "No space left" in state.refused


async def test_reset_is_refused_while_the_disk_is_full(bench: Bench) -> None:
    bench.control.stop_device(StopRequest(device="base", id="i", who="Ben"))
    ask = {"device": "base", "session": "tab", "who": "Ada", "epoch": bench.lease().epoch}
    await bench.control.reset_stop(ResetRequest(**ask))
    token = bench.robot.last(ResetToken).token

    async def full(work: object) -> None:
        raise OSError(28, "No space left on device")

    bench.control._stops._on_disk = full
    await bench.control.reset_stop(ResetRequest(**ask, token=token))
    assert "No space left" in bench.robot.last(ResetToken).refused
    assert bench.robot.last(StopState).latched


def test_a_command_of_somebody_else_is_driven_over_by_nobody(bench: Bench) -> None:
    acting: dict[str, str] = {}
    bench.control.acting_against = lambda _device, who: acting.get(who, "")
    bench.lease()
    bench.drive()
    moved = len(bench.robot.driven)
    acting["tab"] = "Bob is acting on Base: Dock"
    # Who drives when it begins is brought to rest by that, and not by the next frame.
    bench.pass_time(SECOND // 10)
    assert bench.robot.driven[-1][1] == 0.0
    bench.drive()
    bench.pass_time(SECOND // 5)
    assert all(linear == 0.0 for _, linear, _ in bench.robot.driven[moved + 1 :])
    assert bench.robot.last(DriveState).why == "Bob is acting on Base: Dock"
