"""A value that arrives and is none: an error code, one that is frozen, one whose stamp is old."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.clock import SECOND
from talaia.gateway.adapters.connection_scope import scopes_of
from talaia.gateway.adapters.topic_readers import SampleBuffer, TopicPlan, plans_of
from talaia.gateway.errors import FieldError
from talaia.gateway.ports import ChannelReading
from talaia.gateway.safety.interlocks import Interlocks
from talaia.gateway.safety.value_validity import range_problem
from talaia.gateway.samples.source_stamps import StampAge, iso_stamp_ns, stamp_ns_of
from talaia.model.checks.site_checks import check_site
from talaia.model.connection import RosSource
from talaia.model.site import Signal
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import InterlockState

DESCRIPTION = """
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
        unit: km/h
        minimum: 0
        maximum: 100
        max_age: 2
        source: {topic: /w, type: std_msgs/msg/Float64, field: data}
  dome:
    name: Dome
    signals:
      position:
        name: Position
        unit: "%"
        minimum: 0
        maximum: 100
        source: {topic: /p, type: std_msgs/msg/Float64, field: data}
      closed:
        name: Closed
        type: state
        states: ["no", "yes"]
        source: {topic: /c, type: std_msgs/msg/Bool, field: data}
    commands:
      open: {name: Open, target: /open, type: std_srvs/srv/Trigger}
      close: {name: Close, target: /close, type: std_srvs/srv/Trigger}
interlocks:
  weather:
    name: Weather
    when: [{signal: weather/wind, above: 45, lasting: 2}]
    refuse: [dome/open]
    dwell: 0
"""
FROZEN = DESCRIPTION.replace("max_age: 2", "max_age: 2\n        frozen_after: 60")
STAMPED = DESCRIPTION.replace(
    "type: std_msgs/msg/Float64, field: data}\n  dome",
    "type: sensor_msgs/msg/Temperature, field: temperature, stamp: header.stamp}\n  dome",
)
SYNCHRONIZED = STAMPED.replace("header.stamp}", "header.stamp, synchronized: true}")
WALL = 1_800_000_000 * SECOND


class Station:
    """A weather station whose values and stamps are given, and the interlocks that judge them."""

    def __init__(self, description: str = DESCRIPTION) -> None:  # noqa: D107
        self.site = load_site(description)
        assert check_site(self.site) == []
        self.now = 0
        self.skew = 0
        self.latest_of: dict[str, ChannelReading] = {}
        self.ran: list[str] = []
        self.sent: list[object] = []
        self.interlocks = Interlocks(
            site=self.site,
            readings=self,
            output=self,
            run=self.run,
            now_ns=0,
            wall_ns=lambda: WALL + self.now + self.skew,
        )
        (share,) = scopes_of(self.site)
        plans = plans_of(share, self.latest_of, lambda *_: None)
        self.plan: TopicPlan = next(each for each in plans if each.topic == "/w")
        self.wind = 10.0
        self.moves = True
        self.stamp: int | None = WALL

    def latest(self, address: str) -> ChannelReading | None:
        return self.latest_of.get(address)

    def send(self, message: object) -> None:
        self.sent.append(message)

    def record_event(self, kind: str, *_more: object, **_good: object) -> None: ...

    def run(self, label: str, _steps: object) -> None:
        self.ran.append(label)

    def says(self, seconds: float, *, stamps_go_on: bool = True) -> str:
        """Let it say a value ten times a second; give what is refused then."""
        for _ in range(round(seconds * 10)):
            self.now += SECOND // 10
            if stamps_go_on and self.stamp is not None:
                self.stamp += SECOND // 10
            self.wind += 1e-9 if self.moves else 0.0
            stamp = self.stamp or 0
            header = SimpleNamespace(
                stamp=SimpleNamespace(sec=stamp // SECOND, nanosec=stamp % SECOND)
            )
            message = SimpleNamespace(data=self.wind, temperature=self.wind, header=header)
            self.plan.read_message(message, self.now // 1000, self.now, SampleBuffer())
            self.interlocks.evaluate_all(self.now)
        return self.interlocks.refusal_reason("dome", "open", self.now)


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (-999.0, "Wind: -999 km/h is outside 0 … 100 km/h"),
        (998.0, "Wind: 998 km/h is outside 0 … 100 km/h"),
        (-0.1, "Wind: -0.1 km/h is outside 0 … 100 km/h"),
    ],
)
def test_an_error_code_of_the_station_is_unknown_and_unsafe_at_once(
    value: float, said: str
) -> None:
    station = Station()
    assert station.says(1) == ""
    station.wind = value
    # However long a limit has to be passed for: this is no measurement.
    assert station.says(0.2) == f"Weather: {said}"
    station.wind = 10.0
    assert station.says(1) == ""


@given(st.floats(allow_nan=False), st.none() | st.floats(-1e6, 0), st.none() | st.floats(1, 1e6))
def test_a_value_is_out_of_range_exactly_beyond_what_is_described(
    value: float, low: float | None, high: float | None
) -> None:
    signal = Signal(name="W", source=RosSource(), minimum=low, maximum=high)
    out = (low is not None and value < low) or (high is not None and value > high)
    assert bool(range_problem(signal, value)) is out


def test_a_value_frozen_bit_for_bit_is_unknown_until_it_moves() -> None:
    station = Station(FROZEN)
    assert station.says(90) == ""
    station.moves = False
    assert station.says(59) == ""
    assert station.says(2).startswith("Weather: Wind: exactly 10 km/h for 61 s, so it is frozen")
    station.wind = math.nextafter(station.wind, 11)
    assert station.says(1) == ""


def test_a_hub_is_told_which_condition_is_unknown_and_when_it_is_known_again() -> None:
    station = Station(FROZEN)
    station.says(90)

    def told() -> list[str]:
        states = [message for message in station.sent if isinstance(message, InterlockState)]
        return states[-1].unknown

    assert told() == []
    station.moves = False
    station.says(61)
    assert told() == ["weather/wind"]
    # Beyond its limit it is unsafe, but no longer unknown.
    station.moves, station.wind = True, 50.0
    station.says(3)
    assert told() == []


def test_a_signal_that_may_be_still_is_not_frozen() -> None:
    station = Station()
    station.moves = False
    assert station.says(600) == ""


def test_a_value_whose_stamp_stands_still_is_unknown_though_it_goes_on_arriving() -> None:
    station = Station(STAMPED)
    assert station.says(5) == ""
    assert station.says(1.9, stamps_go_on=False) == ""
    said = station.says(0.5, stamps_go_on=False)
    assert said == "Weather: Wind: its own time stamp has stood still for 2 s"
    assert station.says(0.2) == ""


def test_the_first_stamp_proves_nothing_and_a_missing_one_never_does() -> None:
    station = Station(STAMPED)
    assert station.says(0.1) == "Weather: Wind: no value yet"
    assert station.says(0.1) == ""
    station = Station(STAMPED)
    station.stamp = None
    assert station.says(60) == "Weather: Wind: no value yet"


@pytest.mark.parametrize("hours", [-24 * 365, -1, 0, 1, 24 * 365])
def test_a_station_whose_clock_is_wrong_is_believed_as_long_as_it_goes_on(hours: int) -> None:
    station = Station(STAMPED)
    station.stamp = WALL + hours * 3600 * SECOND
    assert station.says(5) == ""
    # Its clock is set, back or forward: one message without progress, and on.
    station.stamp -= 7200 * SECOND
    assert station.says(5) == ""


def test_where_the_clocks_agree_a_stamp_far_from_the_gateways_clock_is_unknown() -> None:
    station = Station(SYNCHRONIZED)
    assert station.says(0.1) == ""
    station.skew = 60 * SECOND
    said = station.says(1)
    assert said == "Weather: Wind: its own time stamp is 60 s behind the gateway's clock"
    station.skew = -60 * SECOND
    said = station.says(1)
    assert said == "Weather: Wind: its own time stamp is 60 s ahead of the gateway's clock"
    station.skew = SECOND
    assert station.says(1) == ""


def test_a_sighting_out_of_its_range_says_nothing() -> None:
    station = Station()
    station.latest_of["dome/position"] = ChannelReading(-999.0, 0)
    assert station.interlocks.conditions.fresh_value("dome/position", 0) is None
    station.latest_of["dome/position"] = ChannelReading(50.0, 0)
    assert station.interlocks.conditions.fresh_value("dome/position", 0) == 50.0


@given(st.lists(st.integers(-5, 5), min_size=1, max_size=30))
def test_a_stamp_is_as_old_as_its_last_advance(steps: list[int]) -> None:
    age, stamp, expected = StampAge(), 0, None
    assert age.add_stamp(stamp, 0) is None
    for now, step in enumerate(steps, 1):
        stamp += step
        expected = now if step > 0 else expected
        assert age.add_stamp(stamp, now) == expected


def test_stamps_of_every_ros_and_of_indi_are_read() -> None:
    ros2 = SimpleNamespace(sec=3, nanosec=5)
    ros1 = SimpleNamespace(secs=3, nsecs=5)
    assert stamp_ns_of(ros2, "s") == stamp_ns_of(ros1, "s") == 3 * SECOND + 5
    assert stamp_ns_of(np.float64(1.5), "s") == 1_500_000_000
    assert (
        iso_stamp_ns("1970-01-01T00:00:02") == iso_stamp_ns("1970-01-01T00:00:02.0Z") == 2 * SECOND
    )
    assert iso_stamp_ns("yesterday") == 0
    for no_time in ("noon", math.nan, True, None):
        with pytest.raises(FieldError, match="no time"):
            stamp_ns_of(no_time, "header.stamp")


MISTAKES = [
    (FROZEN, "frozen_after: 60", "frozen_after: 1", "frozen_after", "may come but once"),
    (FROZEN, "frozen_after: 60", "frozen_after: -1", "frozen_after", "0 or more"),
    (STAMPED, "header.stamp", "header..stamp", "source.stamp", "not the path of a field"),
    (STAMPED, "stamp: header.stamp", "synchronized: true", "synchronized", "no stamp"),
    (
        DESCRIPTION,
        'states: ["no", "yes"]',
        'states: ["no", "yes"]\n        frozen_after: 60',
        "frozen_after",
        "may stay the same",
    ),
]


@pytest.mark.parametrize(("text", "was", "becomes", "where", "problem"), MISTAKES)
def test_a_mistake_in_them_is_told(
    text: str, was: str, becomes: str, where: str, problem: str
) -> None:
    assert was in text
    finding = check_site(load_site(text.replace(was, becomes)))[0]
    assert where in finding.where
    assert problem in finding.problem
