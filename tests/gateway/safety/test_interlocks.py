"""Interlocks: unsafe at once, safe after a dwell time, never OK for unknown, without a hub."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
import pytest
from hypothesis import given, strategies as st
from msgspec import structs

from talaia.clock import MS, SECOND, HandClock
from talaia.gateway.driving.drive_service import DriveService
from talaia.gateway.driving.persistent_state import LeaseEpochs, PersistentStops
from talaia.gateway.driving.stop_writer import StopWriter
from talaia.gateway.ports import ChannelReading
from talaia.gateway.safety.condition_judge import join_verdicts, judge_reading
from talaia.gateway.safety.interlock_state import (
    InterlockChange,
    InterlockStateMachine,
    InterlockVerdict,
)
from talaia.gateway.safety.interlocks import Interlocks
from talaia.model.base import SOURCE_TAG
from talaia.model.connection import RosSource
from talaia.model.interlocks.interlock import Condition, Interlock, Overriding
from talaia.model.interlocks.override_rules import longest_override, never_overridden
from talaia.model.site import Signal, SignalType
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import DriveState, InterlockState, LeaseOp, OverrideRequest

from ..driving.test_drive_service import Bench as ControlBench, Robot

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.model.interlocks.interlock import Step

pytestmark = pytest.mark.pure

SITE = load_site(
    """
talaia: 1
site: s
name: S
ros2: {}
devices:
  weather:
    name: Weather
    signals:
      wind:
        name: Wind
        unit: m/s
        max_age: 2
        source: {topic: /w, type: std_msgs/msg/Float64, field: data}
      rain:
        name: Rain
        type: state
        states: [dry, raining]
        source: {topic: /r, type: std_msgs/msg/Int8, field: data}
  base:
    name: Base
    drive: {topic: /cmd_vel, max_speed: 0.2, max_turn: 2}
  dome:
    name: Dome
    commands:
      open: {name: Open, target: /open, type: std_srvs/srv/Trigger}
      close: {name: Close, target: /close, type: std_srvs/srv/Trigger}
    link_loss: {after: 60, run: [{command: dome/close}]}
interlocks:
  weather:
    name: Bad weather
    when:
      - {signal: weather/wind, above: 12}
      - {signal: weather/rain, is: [raining]}
    refuse: [dome/open, base/drive]
    run: [{command: dome/close}]
    dwell: 30
"""
)
# As the camera of a vehicle that counts people ahead.
SLOW = structs.replace(
    SITE,
    interlocks={
        "people": Interlock(
            name="Somebody ahead",
            when=(Condition(signal="weather/wind", above=0),),
            slow={"base/drive": 0.25},
            dwell=1.0,
        )
    },
)
GOOD = {"weather/wind": 3.0, "weather/rain": 0.0}


class World(Robot):
    """A robot with weather about it."""

    def __init__(self, clock: HandClock) -> None:  # noqa: D107
        super().__init__(clock)
        self.values: dict[str, float] = {}
        self.said: dict[str, ChannelReading] = {}
        self.ran: list[str] = []

    def latest(self, address: str) -> ChannelReading | None:
        if address in self.values:
            return ChannelReading(self.values[address], self.clock.monotonic_ns())
        return self.said.get(address)

    def run(self, label: str, steps: tuple[Step, ...]) -> None:
        self.ran.append(f"{label}: {', '.join(step.command for step in steps)}")


class Bench(ControlBench):
    """A control with interlocks; values are as young as `World.values` says."""

    site = SITE

    def build(self) -> DriveService:
        self.world = self.robot = World(self.clock)
        now = self.clock.monotonic_ns()
        self.interlocks = Interlocks(
            site=self.site,
            readings=self.world,
            output=self.world,
            run=self.world.run,
            now_ns=now,
        )

        async def on_disk(work) -> None:
            work()

        return DriveService(
            site=self.site,
            clock=self.clock,
            output=self.world,
            readings=self.world,
            next_epoch=LeaseEpochs(self.folder / "epochs.json").next_epoch,
            stops=StopWriter(
                stops=PersistentStops(self.folder / "stops.json"),
                on_disk=on_disk,
                output=self.world,
            ),
            interlocks=self.interlocks,
        )

    def refusal(self, device: str = "dome", what: str = "open") -> str:
        return self.interlocks.refusal_reason(device, what, self.clock.monotonic_ns())

    def override(self, seconds: float, reason: str = "testing the shutter") -> None:
        ask = OverrideRequest(interlock="weather", who="Ada", reason=reason, seconds=seconds)
        self.control.override_interlock(ask)


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    one = Bench(tmp_path)
    one.world.values = dict(GOOD)
    return one


@pytest.fixture
def safe(bench: Bench) -> Bench:
    """Long enough after the start, in good weather."""
    bench.pass_time(31 * SECOND)
    assert bench.refusal() == ""
    return bench


def test_after_a_start_it_stays_locked_until_all_was_safe_for_the_dwell_time(bench: Bench) -> None:
    bench.pass_time(29 * SECOND)
    assert bench.refusal() == "Bad weather: the gateway has just started"
    state = bench.robot.last(InterlockState)
    assert (state.locked, state.unsafe) == (True, False)
    bench.pass_time(2 * SECOND)
    assert bench.refusal() == ""
    assert bench.world.ran == []


def test_unsafe_refuses_at_once_what_it_names_and_nothing_else(safe: Bench) -> None:
    safe.world.values["weather/wind"] = 12.5
    assert safe.refusal() == "Bad weather: Wind is above 12 m/s"
    assert safe.refusal("dome", "close") == ""


def test_unsafe_is_told_written_down_and_acted_on_once(safe: Bench) -> None:
    safe.world.values["weather/rain"] = 1.0
    safe.pass_time(200 * MS)
    state = safe.robot.last(InterlockState)
    assert (state.locked, state.unsafe, state.why) == (True, True, "Rain is raining")
    safe.world.values["weather/rain"] = 0.0
    safe.pass_time(5 * SECOND)
    safe.world.values["weather/rain"] = 1.0
    safe.pass_time(5 * SECOND)
    assert safe.world.ran == ["interlock weather: dome/close"]
    assert safe.robot.notes.count("interlock_locked") == 1


def test_a_passing_cloud_does_not_pump_the_shutter(safe: Bench) -> None:
    for _ in range(5):
        safe.world.values["weather/rain"] = 1.0
        safe.pass_time(SECOND)
        safe.world.values["weather/rain"] = 0.0
        safe.pass_time(29 * SECOND)
        assert safe.refusal()
    safe.pass_time(2 * SECOND)
    assert safe.refusal() == ""
    assert safe.robot.notes.count("interlock_released") == 2
    assert len(safe.world.ran) == 1


def test_a_value_that_stops_coming_is_unsafe_within_its_limit(safe: Bench) -> None:
    now = safe.clock.monotonic_ns()
    safe.world.said["weather/wind"] = ChannelReading(safe.world.values.pop("weather/wind"), now)
    safe.pass_time(1900 * MS)
    assert safe.refusal() == ""
    safe.pass_time(200 * MS)
    assert safe.refusal() == "Bad weather: Wind: no value newer than 2 s"
    assert safe.world.ran == ["interlock weather: dome/close"]


def test_a_gateway_that_hears_nothing_yet_is_locked_but_does_not_act_before_it_can_know(
    bench: Bench,
) -> None:
    bench.world.values = {"weather/rain": 0.0}
    bench.pass_time(1900 * MS)
    assert bench.refusal() == "Bad weather: Wind: no value yet"
    assert bench.world.ran == []
    bench.pass_time(200 * MS)
    assert bench.world.ran == ["interlock weather: dome/close"]


def test_driving_ends_with_zero_when_it_becomes_unsafe_and_needs_a_new_press(safe: Bench) -> None:
    safe.lease()
    safe.drive()
    assert safe.robot.driven[-1][1] > 0
    safe.world.values["weather/rain"] = 1.0
    safe.pass_time(100 * MS)
    assert safe.robot.driven[-1][1:] == (0.0, 0.0)
    safe.drive()
    safe.pass_time(100 * MS)
    assert safe.robot.last(DriveState).why == "Bad weather: Rain is raining"
    safe.world.values["weather/rain"] = 0.0
    while safe.refusal("base", "drive"):
        safe.lease(op=LeaseOp.RENEW)
        safe.drive()
        safe.pass_time(50 * MS)
    moved = len(safe.robot.driven)
    for _ in range(10):
        safe.drive()
        safe.pass_time(50 * MS)
    assert {x[1] for x in safe.robot.driven[moved:]} <= {0.0}
    safe.drive(linear=0.0)
    safe.pass_time(50 * MS)
    safe.drive()
    assert safe.robot.driven[-1][1] > 0


@pytest.fixture
def slowed(tmp_path: Path) -> Bench:
    """A vehicle that drives at its full speed of 0.2 m/s, with nobody ahead."""

    class SlowedBench(Bench):
        site = SLOW

    one = SlowedBench(tmp_path)
    one.world.values = {"weather/wind": 0.0, "weather/rain": 0.0}
    one.pass_time(2 * SECOND)
    one.lease()
    hold(one, 1000 * MS)
    assert one.robot.driven[-1][1] == pytest.approx(0.2)
    assert one.robot.last(DriveState).cap == 1.0
    return one


def hold(bench: Bench, ns: int) -> None:
    for _ in range(ns // (50 * MS)):
        bench.lease(op=LeaseOp.RENEW)
        bench.drive(linear=0.2)
        bench.pass_time(50 * MS)


def test_what_slows_down_caps_whoever_drives_and_lets_go_after_the_dwell_time(
    slowed: Bench,
) -> None:
    slowed.world.values["weather/wind"] = 1.0
    slowed.drive(linear=0.2)
    slowed.pass_time(100 * MS)
    assert slowed.robot.driven[-1][1] == pytest.approx(0.05)
    hold(slowed, 500 * MS)
    moved = len(slowed.robot.driven)
    hold(slowed, 500 * MS)
    # Slower, and not ended: nobody needs to press anew.
    told = [each[1] for each in slowed.robot.driven[moved:]]
    assert told == [pytest.approx(0.05)] * len(told)
    assert slowed.robot.last(DriveState).cap == 0.25
    assert slowed.robot.last(DriveState).why == ""
    slowed.world.values["weather/wind"] = 0.0
    hold(slowed, 900 * MS)
    assert slowed.robot.driven[-1][1] == pytest.approx(0.05)
    hold(slowed, 1200 * MS)
    assert slowed.robot.driven[-1][1] == pytest.approx(0.2)


def test_a_held_drive_is_slowed_without_its_next_frame(slowed: Bench) -> None:
    slowed.drive(linear=0.2)
    slowed.world.values["weather/wind"] = 1.0
    slowed.pass_time(150 * MS)
    assert slowed.robot.driven[-1][1] == pytest.approx(0.05)


def test_what_is_unknown_slows_down_too_and_what_is_overridden_does_not(slowed: Bench) -> None:
    slowed.world.values["weather/wind"] = float("nan")
    hold(slowed, 200 * MS)
    assert slowed.robot.driven[-1][1] == pytest.approx(0.05)
    slowed.world.values["weather/wind"] = 2.0
    hold(slowed, 200 * MS)
    ask = OverrideRequest(interlock="people", who="Ada", reason="the camera is dirty", seconds=60)
    slowed.control.override_interlock(ask)
    hold(slowed, 500 * MS)
    assert slowed.robot.driven[-1][1] == pytest.approx(0.2)
    assert slowed.refusal("base", "drive") == ""


def test_no_hub_is_needed_for_any_of_it(safe: Bench) -> None:
    safe.control.link_lost()
    safe.world.values["weather/rain"] = 1.0
    safe.pass_time(200 * MS)
    assert safe.refusal()
    assert safe.world.ran == ["interlock weather: dome/close"]


def test_an_override_lasts_as_long_as_was_said_and_then_it_acts(safe: Bench) -> None:
    safe.world.values["weather/wind"] = 13.0
    safe.pass_time(200 * MS)
    safe.override(60)
    assert safe.refusal() == ""
    state = safe.robot.last(InterlockState)
    assert (state.overridden_by, state.reason) == ("Ada", "testing the shutter")
    assert state.override_ms == 60_000
    assert "interlock_overridden" in safe.robot.notes
    safe.pass_time(59 * SECOND)
    assert safe.refusal() == ""
    safe.pass_time(2 * SECOND)
    assert safe.refusal()
    assert "override_ended" in safe.robot.notes
    assert len(safe.world.ran) == 2


@pytest.mark.parametrize(
    ("seconds", "reason"), [(60, " "), (1801, "too long"), (-1, "never"), (float("nan"), "x")]
)
def test_an_override_without_reason_or_bound_is_refused(
    safe: Bench, seconds: float, reason: str
) -> None:
    safe.world.values["weather/wind"] = 13.0
    safe.pass_time(200 * MS)
    safe.override(seconds, reason)
    assert safe.refusal()
    assert safe.robot.notes[-1] == "override_refused"


def test_an_override_can_be_ended_early(safe: Bench) -> None:
    safe.world.values["weather/wind"] = 13.0
    safe.pass_time(200 * MS)
    safe.override(600)
    safe.override(0)
    assert safe.refusal()


def test_rain_and_what_is_unknown_are_never_overridden(safe: Bench) -> None:
    safe.world.values["weather/rain"] = 1.0
    safe.pass_time(200 * MS)
    safe.override(60)
    assert safe.robot.notes[-1] == "override_refused"
    assert safe.robot.last(InterlockState).no_override == "Rain: rain is never overridden"
    safe.world.values["weather/rain"] = 0.0
    safe.pass_time(31 * SECOND)
    safe.world.values["weather/wind"] = float("nan")
    safe.pass_time(200 * MS)
    safe.override(60)
    assert safe.refusal()
    assert "unknown" in safe.robot.last(InterlockState).no_override


def test_nothing_is_overridden_while_nothing_is_locked(safe: Bench) -> None:
    safe.override(60)
    assert safe.robot.notes[-1] == "override_refused"
    safe.world.values["weather/wind"] = 13.0
    safe.pass_time(200 * MS)
    assert safe.refusal()


def test_an_override_is_of_one_condition_and_another_still_locks(safe: Bench) -> None:
    safe.world.values["weather/wind"] = 13.0
    safe.pass_time(200 * MS)
    assert safe.robot.last(InterlockState).condition == "weather/wind"
    safe.override(600)
    assert safe.refusal() == ""
    ran = len(safe.world.ran)
    safe.world.values["weather/rain"] = 1.0
    safe.pass_time(200 * MS)
    assert "Bad weather" in safe.refusal()
    assert safe.robot.notes.count("override_ended") == 1
    # And it acts: the roof that was open by leave of somebody closes in the rain.
    assert len(safe.world.ran) == ran + 1
    safe.override(600)
    assert safe.robot.notes[-1] == "override_refused"


def test_a_condition_that_becomes_unknown_while_it_is_overridden_locks(safe: Bench) -> None:
    safe.world.values["weather/wind"] = 13.0
    safe.pass_time(200 * MS)
    safe.override(600)
    safe.world.values["weather/wind"] = float("inf")
    safe.pass_time(200 * MS)
    assert "not a number" in safe.refusal()
    assert "override_ended" in safe.robot.notes


def test_an_override_is_over_when_there_is_nothing_left_to_override(safe: Bench) -> None:
    safe.world.values["weather/wind"] = 13.0
    safe.pass_time(200 * MS)
    safe.override(600)
    safe.world.values["weather/wind"] = 3.0
    safe.pass_time(31 * SECOND)
    assert "override_ended" in safe.robot.notes
    safe.world.values["weather/wind"] = 13.0
    safe.pass_time(200 * MS)
    assert safe.refusal()


def test_the_condition_that_is_named_must_be_the_one_that_locks(safe: Bench) -> None:
    safe.world.values["weather/wind"] = 13.0
    safe.pass_time(200 * MS)
    ask = OverrideRequest(interlock="weather", who="Ada", reason="x", seconds=60)
    safe.control.override_interlock(structs.replace(ask, condition="weather/rain"))
    assert safe.refusal()
    safe.control.override_interlock(structs.replace(ask, condition="weather/wind"))
    assert safe.refusal() == ""


@pytest.mark.parametrize(
    ("signal", "condition", "never"),
    [
        ({"unit": "mm/h"}, {"above": 0}, "rain"),
        ({"name": "Precipitation"}, {"above": 0}, "rain"),
        ({"name": "Rain rate"}, {"above": 0}, "rain"),
        ({"type": "state", "states": ("dry", "wet")}, {"is_one_of": ("wet",)}, "rain"),
        ({"type": "state", "states": ("dry", "raining")}, {"is_not": ("dry",)}, "rain"),
        ({"type": "state", "states": ("local", "remote")}, {"is_one_of": ("local",)}, "on site"),
        ({"type": "state", "states": ("local", "remote")}, {"is_one_of": ("remote",)}, ""),
        ({"name": "Terrain"}, {"above": 0}, ""),
        ({"name": "Wind", "unit": "m/s"}, {"above": 0}, ""),
        ({"name": "Wind", "unit": "m/s"}, {"above": 0, "override": Overriding.NEVER}, "described"),
    ],
)
def test_rain_and_the_switch_on_site_are_recognised(
    signal: dict, condition: dict, never: str
) -> None:
    described = msgspec.convert(
        {"name": "W", "source": {SOURCE_TAG: "ros", "topic": "/w"}, **signal}, Signal
    )
    device = structs.replace(SITE.devices["weather"], signals={"w": described})
    site = structs.replace(SITE, devices={"weather": device})
    one = structs.replace(Condition(signal="weather/w"), **condition)
    found = never_overridden(site, one)
    assert never in found
    assert bool(found) == bool(never)
    # A group with it is not overridden either.
    group = Condition(all_of=(one, Condition(signal="weather/w", above=1)))
    assert bool(never_overridden(site, group)) == bool(never)


def test_longer_than_half_an_hour_is_half_an_hour_whatever_is_described() -> None:
    assert longest_override(Interlock(name="I", when=(), longest_override=3600)) == 1800
    assert longest_override(Interlock(name="I", when=())) == 1800
    assert longest_override(Interlock(name="I", when=(), longest_override=60)) == 60


def test_a_new_link_is_told_how_all_stand(safe: Bench) -> None:
    safe.control.link_lost()
    safe.robot.sent.clear()
    safe.control.link_up()
    assert safe.robot.last(InterlockState).locked is False


def test_link_loss_policy_acts_once_after_its_time_and_not_if_the_link_is_back(
    safe: Bench,
) -> None:
    safe.control.link_lost()
    safe.pass_time(59 * SECOND)
    safe.control.link_up()
    safe.pass_time(10 * SECOND)
    assert safe.world.ran == []
    safe.control.link_lost()
    safe.pass_time(61 * SECOND)
    safe.pass_time(300 * SECOND)
    assert safe.world.ran == ["link loss dome: dome/close"]
    assert "link_loss_acted" in safe.robot.notes


def test_a_gateway_that_never_finds_its_hub_acts_too(tmp_path: Path) -> None:
    bench = Bench(tmp_path)
    bench.control = bench.build()
    bench.world.values = dict(GOOD)
    bench.pass_time(61 * SECOND)
    assert bench.world.ran == ["link loss dome: dome/close"]


WIND = Signal(
    name="Wind",
    max_age=2.0,
    source=RosSource(topic="/w", type="std_msgs/msg/Float64", field="data"),
)
RAIN = Signal(name="Rain", type=SignalType.STATE, states=("dry", "wet"), source=WIND.source)
anything = st.floats(allow_nan=True, allow_infinity=True)


@given(anything, st.integers(0, 10 * SECOND), st.booleans(), anything)
def test_only_a_fresh_finite_value_within_limits_is_safe(
    value: float,
    age: int,
    known: bool,  # noqa: FBT001 - given by the test's own table
    limit: float,
) -> None:
    reading = ChannelReading(value, 0) if known else None
    verdict = judge_reading(
        condition=Condition(signal="w/w", above=limit), signal=WIND, reading=reading, age_ns=age
    )
    if not verdict.why:
        assert known
        assert age <= 2 * SECOND
        assert abs(value) < float("inf")
        assert not value > limit


@given(anything, st.lists(st.sampled_from(["dry", "wet"])), st.lists(st.sampled_from(["dry"])))
def test_a_state_that_is_none_of_the_described_is_never_safe(
    value: float, bad: list[str], good: list[str]
) -> None:
    condition = Condition(signal="w/r", is_one_of=tuple(bad), is_not=tuple(good))
    verdict = judge_reading(
        condition=condition, signal=RAIN, reading=ChannelReading(value, 0), age_ns=0
    )
    if not verdict.why:
        assert value in (0.0, 1.0)
        word = RAIN.states[int(value)]
        assert word not in bad
        assert not good or word in good


verdicts = st.builds(
    InterlockVerdict, st.sampled_from(["", "wet", "cold", "x" * 400]), st.booleans()
)


@given(st.lists(verdicts, max_size=8))
def test_conditions_together_are_unsafe_exactly_while_each_is_and_certain_only_if_all_are(
    parts: list[InterlockVerdict],
) -> None:
    verdict = join_verdicts(parts)
    assert bool(verdict.why) == (bool(parts) and all(part.why for part in parts))
    assert len(verdict.why) <= 500
    if verdict.why:
        assert verdict.certain == all(part.certain for part in parts)


def test_what_is_harmless_alone_locks_together_and_a_silent_one_counts_as_unsafe(
    tmp_path: Path,
) -> None:
    rain, wind = SITE.interlocks["weather"].when[1], SITE.interlocks["weather"].when[0]
    rule = structs.replace(SITE.interlocks["weather"], when=(Condition(all_of=(wind, rain)),))
    both = structs.replace(SITE, interlocks={"weather": rule})
    assert both.safety_signals() == {"weather/wind", "weather/rain"}

    class BenchOfBoth(Bench):
        site = both

    bench = BenchOfBoth(tmp_path)
    bench.world.values = dict(GOOD)
    bench.pass_time(31 * SECOND)
    assert bench.refusal() == ""
    bench.world.values["weather/wind"] = 20.0
    bench.pass_time(SECOND)
    assert bench.refusal() == ""
    bench.world.values["weather/rain"] = 1.0
    assert bench.refusal() == "Bad weather: Wind is above 12 m/s and Rain is raining"
    bench.world.values = {"weather/rain": 1.0}
    bench.pass_time(3 * SECOND)
    assert "Wind: no value" in bench.refusal()
    bench.world.values["weather/rain"] = 0.0
    bench.pass_time(31 * SECOND)
    # Dry is enough: a vane that is silent cannot make both true.
    assert bench.refusal() == ""


looks = st.tuples(
    st.sampled_from(["safe", "unsafe", "unsure", "override", "end"]), st.integers(0, 20)
)


@given(st.lists(looks, max_size=100))
def test_it_refuses_while_unsafe_and_for_the_whole_dwell_time_after(
    history: list[tuple[str, int]],
) -> None:
    rule = Interlock(name="R", when=(), dwell=30.0)
    one, now, unsafe_ns, over_until = InterlockStateMachine("r", rule, 0), 0, 0, -1
    verdict, fired = InterlockVerdict(), False
    for what, seconds in history:
        # Looked at each second, as the gateway does ten times a second.
        for _ in range(seconds):
            now += SECOND
            changes = one.update_state(verdict, now)
            if verdict.why:
                unsafe_ns = now
            if InterlockChange.OVERRIDE_ENDED in changes:
                over_until = -1
            overridden = now < over_until
            safe_for = now - unsafe_ns
            if overridden:
                assert not one.locked
            elif verdict.why or safe_for < 30 * SECOND:
                assert one.locked
            elif safe_for > 31 * SECOND:
                assert not one.locked
            if InterlockChange.OVERRIDE_ENDED in changes:
                fired = False
            if InterlockChange.FIRED in changes:
                assert verdict.certain
                assert verdict.why
                assert not overridden
                assert not fired
                fired = True
            if InterlockChange.RELEASED in changes:
                fired = False
        match what:
            case "safe":
                verdict = InterlockVerdict()
            case "unsafe":
                verdict = InterlockVerdict("it rains")
            case "unsure":
                verdict = InterlockVerdict("nothing yet", certain=False)
            case "override":
                if not one.override_condition(who="Ada", reason="to see", seconds=45.0, now_ns=now):
                    over_until = now + 45 * SECOND
            case "end":
                one.override_condition(who="Ada", reason="", seconds=0.0, now_ns=now)
                over_until = -1
