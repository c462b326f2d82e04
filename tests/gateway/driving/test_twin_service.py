"""Where what is driven in a twin goes: the twin alone, or the robot under its own rules."""

from __future__ import annotations

from itertools import count
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.clock import MS, SECOND, HandClock
from talaia.gateway.driving.drive_service import DriveService
from talaia.gateway.driving.persistent_state import LeaseEpochs, PersistentStops
from talaia.gateway.driving.stop_writer import StopWriter
from talaia.gateway.driving.twin_service import NOT_HELD, NOT_LIVE, TwinService
from talaia.gateway.ports import ChannelReading
from talaia.gateway.safety.interlocks import Interlocks
from talaia.gateway.velocity_demand import VelocityDemand
from talaia.model.twins.twin import TwinMode
from talaia.model.twins.twin_topics import device_text
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import (
    LeaseOp,
    LeaseRequest,
    StopRequest,
    TwinFrame,
    TwinOp,
    TwinRequest,
    TwinState,
)

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.pure

ODOMETRY = "topic: /odom, type: nav_msgs/msg/Odometry"
SITE = load_site(
    f"""
talaia: 1
site: s
name: S
ros2: {{}}
devices:
  base:
    name: Base
    signals:
      pose: {{name: P, type: position, source: {{{ODOMETRY}, field: pose.pose.position}}}}
      rain: {{name: Rain, source: {{topic: /rain, type: std_msgs/msg/Float64, field: data}}}}
    drive: {{topic: /cmd_vel, max_speed: 0.2, max_turn: 2, position: base/pose}}
{device_text("twin", "base")}
interlocks:
  rain: {{name: Rain, when: [{{signal: base/rain, above: 0}}], refuse: [base/drive], dwell: 0}}
"""
)


class World:
    """What robot and twin are told, what the hub hears, and what the gateway reads."""

    def __init__(self, clock: HandClock) -> None:  # noqa: D107
        self.clock = clock
        self.driven: dict[str, list[float]] = {"base": [], "twin": []}
        self.sent: list[object] = []
        self.notes: list[str] = []
        self.readings: dict[str, ChannelReading] = {}

    def read(self, **values: float) -> None:
        for name, value in values.items():
            address = name.replace("__", "/").replace("pose_x", "pose.x")
            address = address.replace("pose_yaw", "pose.yaw").replace("pose_y", "pose.y")
            self.readings[address] = ChannelReading(value, self.clock.monotonic_ns())

    def drive(self, device: str, demand: VelocityDemand, key: str = "") -> None:
        self.driven[device].append(demand.linear)

    def stop(self, device: str, *, stopped: bool) -> None:
        assert device == "base"

    def send(self, message: object) -> None:
        self.sent.append(message)

    def record_event(self, kind: str, device: str, message: str, who: str, *, good: bool) -> None:
        self.notes.append(kind)

    def latest(self, address: str) -> ChannelReading | None:
        return self.readings.get(address)

    @property
    def twin(self) -> TwinState:
        return [one for one in self.sent if isinstance(one, TwinState)][-1]

    def moved(self, device: str) -> bool:
        """Tell whether a device was told to move since this was asked last."""
        told, self.driven[device] = self.driven[device], []
        return any(told)


class Bench:
    """A gateway's driving with a twin."""

    def __init__(self, folder: Path) -> None:  # noqa: D107
        self.clock = HandClock(monotonic_ns=100 * SECOND)
        self.world = World(self.clock)
        self.seq = count()

        async def on_disk(work) -> None:
            work()

        self.driving = DriveService(
            site=SITE,
            clock=self.clock,
            output=self.world,
            readings=self.world,
            next_epoch=LeaseEpochs(folder / "epochs.json").next_epoch,
            stops=StopWriter(
                stops=PersistentStops(folder / "stops.json"), on_disk=on_disk, output=self.world
            ),
            interlocks=Interlocks(
                site=SITE,
                readings=self.world,
                output=self.world,
                run=lambda _label, _steps: None,
                now_ns=self.clock.monotonic_ns(),
                wall_ns=self.clock.wall_ns,
            ),
        )
        self.twins = TwinService(
            site=SITE,
            driving=self.driving,
            readings=self.world,
            output=self.world,
            clock=self.clock,
        )
        self.driving.link_up()
        self.twins.link_up()
        self.mode = TwinMode.FOLLOWING
        self.error, self.rain, self.alive = 0.0, 0.0, True
        self.x = 0.0
        self.pass_time(SECOND)

    def speak(self) -> None:
        self.world.read(base__rain=self.rain)
        if self.alive:
            self.world.read(
                twin__mode=float(self.mode),
                twin__pose_error=self.error,
                twin__pose_x=self.x,
                twin__pose_y=0.0,
                twin__pose_yaw=0.0,
            )

    def pass_time(self, ns: int) -> None:
        """Let time pass in steps of 10 ms: robot and twin speak, and what is due is done."""
        for _ in range(ns // (10 * MS)):
            self.clock.advance(10 * MS)
            self.speak()
            due = self.twins.due_ns()
            if due is not None and due <= self.clock.monotonic_ns():
                self.twins.run_due()

    def lease(self, session: str = "tab", op: LeaseOp = LeaseOp.TAKE) -> int:
        self.driving.handle_lease(LeaseRequest(device="base", session=session, who=session, op=op))
        held = self.driving.controllers["base"].lease.holder_at(self.clock.monotonic_ns())
        return 0 if held is None else held.epoch

    def switch(self, op: TwinOp, epoch: int, session: str = "tab") -> None:
        self.twins.handle_request(
            TwinRequest(device="base", session=session, epoch=epoch, who=session, op=op)
        )

    def drive(self, epoch: int, *, live: bool, linear: float = 0.1, session: str = "tab") -> None:
        self.twins.handle_frame(
            TwinFrame(
                device="base",
                session=session,
                epoch=epoch,
                seq=next(self.seq),
                tick=max(0, self.driving.ticks.last),
                linear=linear,
                angular=0.0,
                live=live,
            )
        )

    def hold(self, epoch: int, *, live: bool, seconds: float = 0.3) -> None:
        for _ in range(round(seconds / 0.05)):
            self.lease(op=LeaseOp.RENEW)
            self.drive(epoch, live=live)
            self.pass_time(50 * MS)


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    return Bench(tmp_path)


def test_what_is_driven_alone_reaches_the_twin_and_never_the_robot(bench: Bench) -> None:
    epoch = bench.lease()
    bench.hold(epoch, live=False)
    assert bench.world.moved("twin")
    assert not bench.world.moved("base")


def test_a_frame_that_says_live_moves_nothing_while_live_is_off(bench: Bench) -> None:
    epoch = bench.lease()
    bench.hold(epoch, live=True)
    assert not bench.world.moved("base")
    assert not bench.world.moved("twin")
    assert bench.world.twin.why == NOT_LIVE


def test_live_sends_what_is_driven_in_the_twin_to_the_robot(bench: Bench) -> None:
    epoch = bench.lease()
    bench.switch(TwinOp.LIVE, epoch)
    assert bench.world.twin.live
    bench.drive(epoch, live=True, linear=0.0)
    bench.hold(epoch, live=True)
    assert bench.world.moved("base")
    # It follows by what it sees; it is not driven a second time.
    assert not bench.world.moved("twin")


def test_what_is_held_while_live_is_switched_on_does_not_move_the_robot(bench: Bench) -> None:
    """The hand on the stick meant the twin: it lets go before the robot moves."""
    epoch = bench.lease()
    bench.switch(TwinOp.LIVE, epoch)
    bench.hold(epoch, live=True)
    assert not bench.world.moved("base")


def test_without_the_lease_a_twin_is_not_driven(bench: Bench) -> None:
    epoch = bench.lease("other")
    bench.drive(epoch, live=False)
    assert not bench.world.moved("twin")
    assert bench.world.twin.why == NOT_HELD
    bench.switch(TwinOp.LIVE, epoch)
    assert not bench.world.twin.live


def test_live_ends_with_the_lease(bench: Bench) -> None:
    epoch = bench.lease()
    bench.switch(TwinOp.LIVE, epoch)
    bench.lease(op=LeaseOp.FREE)
    bench.pass_time(SECOND)
    assert not bench.world.twin.live
    again = bench.lease()
    bench.drive(again, live=True, linear=0.0)
    bench.hold(again, live=True)
    assert not bench.world.moved("base")


def test_stop_ends_live_and_the_rehearsal(bench: Bench) -> None:
    epoch = bench.lease()
    bench.hold(epoch, live=False)
    bench.world.moved("twin")
    bench.driving.stop_device(StopRequest(device="base", id="1", who="x"))
    bench.twins.stop_device("base")
    bench.hold(epoch, live=False)
    assert not bench.world.moved("twin")
    bench.switch(TwinOp.LIVE, epoch)
    assert not bench.world.twin.live
    assert bench.world.twin.why == "STOP is on"


def test_a_twin_that_dies_ends_live_within_a_second_and_a_bit_and_the_robot_stands(
    bench: Bench,
) -> None:
    epoch = bench.lease()
    bench.switch(TwinOp.LIVE, epoch)
    bench.drive(epoch, live=True, linear=0.0)
    bench.hold(epoch, live=True)
    bench.alive = False
    bench.hold(epoch, live=True, seconds=1.2)
    assert not bench.world.twin.live
    assert "not heard" in bench.world.twin.why or bench.world.twin.why == NOT_LIVE
    bench.world.moved("base")
    bench.hold(epoch, live=True)
    assert not bench.world.moved("base")


def test_a_robot_is_driven_as_ever_when_its_twin_is_dead(bench: Bench) -> None:
    from talaia.gateway.driving.twin_controller import drive_frame_of

    bench.alive = False
    epoch = bench.lease()
    bench.pass_time(3 * SECOND - 50 * MS)
    epoch = bench.lease(op=LeaseOp.RENEW) or bench.lease()
    frame = TwinFrame(
        device="base",
        session="tab",
        epoch=epoch,
        seq=next(bench.seq),
        tick=max(0, bench.driving.ticks.last),
        linear=0.1,
        angular=0.0,
    )
    bench.driving.handle_frame(drive_frame_of(frame))
    assert bench.world.moved("base")


@pytest.mark.parametrize("mode", [TwinMode.WAITING, TwinMode.REHEARSING])
def test_live_needs_a_twin_that_follows(bench: Bench, mode: TwinMode) -> None:
    bench.mode = mode
    epoch = bench.lease()
    bench.pass_time(100 * MS)
    bench.switch(TwinOp.LIVE, epoch)
    assert not bench.world.twin.live


def test_live_needs_a_twin_that_is_near(bench: Bench) -> None:
    bench.error = 0.6
    epoch = bench.lease()
    bench.pass_time(100 * MS)
    bench.switch(TwinOp.LIVE, epoch)
    assert not bench.world.twin.live
    assert bench.world.twin.why == "the twin is 0.60 m from the robot"


def test_an_interlock_stops_the_robot_and_is_told_of_a_rehearsal(bench: Bench) -> None:
    epoch = bench.lease()
    bench.switch(TwinOp.LIVE, epoch)
    bench.rain = 1.0
    bench.pass_time(200 * MS)
    bench.drive(epoch, live=True, linear=0.0)
    bench.hold(epoch, live=True)
    assert not bench.world.moved("base")
    bench.switch(TwinOp.ALONE, epoch)
    bench.mode = TwinMode.REHEARSING
    for step in range(4):
        bench.x = 0.1 * step
        bench.hold(epoch, live=False)
    assert bench.world.moved("twin")
    assert not bench.world.moved("base")
    (verdict,) = bench.world.twin.verdicts
    assert verdict.why.startswith("Rain: ")
    assert bench.world.twin.path[-3:] == pytest.approx([0.3, 0, 0])
    bench.switch(TwinOp.CLEAR, epoch)
    assert bench.world.twin.path == []


def test_a_rehearsal_begins_a_path_of_its_own(bench: Bench) -> None:
    epoch = bench.lease()
    bench.mode, bench.x = TwinMode.REHEARSING, 5.0
    bench.hold(epoch, live=False)
    bench.mode = TwinMode.FOLLOWING
    bench.hold(epoch, live=False)
    # The one before is shown until there is another.
    assert bench.world.twin.path[0] == 5.0
    bench.mode, bench.x = TwinMode.REHEARSING, 1.0
    bench.hold(epoch, live=False)
    assert bench.world.twin.path[0] == 1.0


def test_driving_the_twin_alone_ends_live(bench: Bench) -> None:
    epoch = bench.lease()
    bench.switch(TwinOp.LIVE, epoch)
    bench.drive(epoch, live=False)
    assert bench.world.notes.count("twin_alone") == 1
    bench.drive(epoch, live=True)
    assert not bench.world.moved("base")


STEPS = st.sampled_from(
    ["live", "alone", "free", "take", "stop", "die", "revive", "rehearse", "follow", "wait"]
)


@given(st.lists(st.tuples(STEPS, st.booleans()), max_size=25))
@settings(max_examples=examples(40, many=1500), deadline=None)
def test_the_robot_moves_only_by_live_frames_while_live_is_on(
    tmp_path_factory: pytest.TempPathFactory, story: list[tuple[str, bool]]
) -> None:
    """Whatever happens in whatever order."""
    bench = Bench(tmp_path_factory.mktemp("story"))
    epoch, may = bench.lease(), False
    for step, live in story:
        match step:
            case "live":
                bench.switch(TwinOp.LIVE, epoch)
            case "alone":
                bench.switch(TwinOp.ALONE, epoch)
            case "free":
                bench.lease(op=LeaseOp.FREE)
            case "take":
                epoch = bench.lease()
            case "stop":
                bench.driving.stop_device(StopRequest(device="base", id="1", who="x"))
                bench.twins.stop_device("base")
            case "die" | "revive":
                bench.alive = step == "revive"
            case "rehearse" | "follow":
                bench.mode = TwinMode.REHEARSING if step == "rehearse" else TwinMode.FOLLOWING
            case _:
                bench.pass_time(400 * MS)
        bench.pass_time(20 * MS)
        bench.world.moved("base")
        may = bench.world.twin.live and live
        bench.drive(epoch, live=live)
        assert may or not bench.world.moved("base")
