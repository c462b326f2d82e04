"""A roof whose sensors disagree is not closed, and somebody hears of it."""

from __future__ import annotations

from dataclasses import astuple

import pytest
from hypothesis import given, strategies as st

from talaia.clock import SECOND
from talaia.gateway.ports import ChannelReading
from talaia.gateway.safety.interlocks import Interlocks
from talaia.gateway.safety.sensor_agreement import RoofSensor, closed_by
from talaia.model.checks.site_checks import check_site
from talaia.model.interlocks.capabilities import Capabilities, capabilities_of
from talaia.model.yaml_text.load import dump_site, load_site
from talaia.wire.frames import EnclosureState

DESCRIPTION = """
talaia: 1
site: s
name: S
ros2: {}
devices:
  weather:
    name: Weather
    signals:
      rain:
        {name: Rain, type: state, states: [dry, wet],
         source: {topic: /r, type: std_msgs/msg/Bool, field: data}}
  dome:
    name: Dome
    signals:
      closed:
        {name: Closed switch, type: state, states: ["no", "yes"],
         source: {topic: /c, type: std_msgs/msg/Bool, field: data}}
      position:
        {name: Opening, unit: "%", minimum: 0, maximum: 100,
         source: {topic: /p, type: std_msgs/msg/Float64, field: data}}
      west:
        {name: West, unit: "%", minimum: 0, maximum: 100,
         source: {topic: /w, type: std_msgs/msg/Float64, field: data}}
      east:
        {name: East, unit: "%", minimum: 0, maximum: 100,
         source: {topic: /e, type: std_msgs/msg/Float64, field: data}}
      flap:
        {name: Flap switch, type: state, states: [open, closed],
         source: {topic: /f, type: std_msgs/msg/Bool, field: data}}
    commands:
      close: {name: Close, target: /close, type: std_srvs/srv/Trigger}
      close_flap: {name: Close flap, target: /flap, type: std_srvs/srv/Trigger}
interlocks:
  rain:
    name: Rain
    when: [{signal: weather/rain, is: [wet]}]
    refuse: [dome/*]
    dwell: 0
enclosures:
  dome:
    name: Dome
    unsafe: [rain]
    closed:
      - {signal: dome/closed, is: ["yes"]}
      - {signal: dome/position, below: 1}
    close: {command: dome/close}
    order: parallel
    retries: 2
    disagree_after: 10
"""
CLAMSHELL = (
    DESCRIPTION
    + """
    segments:
      west: {name: West shell, closed: [{signal: dome/west, below: 1}], position: dome/west}
      east: {name: East shell, closed: [{signal: dome/east, below: 1}], position: dome/east}
"""
)
FLAP = (
    DESCRIPTION
    + """
    flap:
      name: Flap
      closed: [{signal: dome/flap, is: [closed]}]
      close: {command: dome/close_flap}
"""
)
CLOSED = {"closed": 1.0, "position": 0.0, "west": 0.0, "east": 0.0, "flap": 1.0}
OPEN = {"closed": 0.0, "position": 100.0, "west": 100.0, "east": 100.0, "flap": 0.0}


class Roof:
    """Interlocks over a roof whose sensors say what a test wants."""

    def __init__(self, description: str = DESCRIPTION) -> None:  # noqa: D107
        self.site = load_site(description)
        assert check_site(self.site) == []
        assert load_site(dump_site(self.site)) == self.site
        self.now = 0
        self.sensors = dict(CLOSED)
        # By sensor: when it spoke last, where that is not just now.
        self.said: dict[str, int] = {}
        self.rain = 0.0
        self.asked: list[str] = []
        self.notes: list[tuple[str, str]] = []
        self.problems: list[str] = []
        self.interlocks = Interlocks(
            site=self.site, readings=self, output=self, run=self.run, now_ns=0
        )

    def latest(self, address: str) -> ChannelReading | None:
        device, _, signal = address.partition("/")
        value = self.rain if device == "weather" else self.sensors.get(signal)
        return None if value is None else ChannelReading(value, self.said.get(signal, self.now))

    def send(self, message: object) -> None:
        if isinstance(message, EnclosureState):
            self.problems.append(message.why)

    def record_event(
        self, kind: str, _device: str, message: str, *_more: object, **_good: object
    ) -> None:
        self.notes.append((kind, message))

    def run(self, _label: str, steps: tuple) -> None:
        self.asked += [step.command for step in steps]

    def lasts(self, seconds: float, **sensors: float | None) -> None:
        self.sensors |= {name: value for name, value in sensors.items() if value is not None}
        for name in [name for name, value in sensors.items() if value is None]:
            del self.sensors[name]
        for _ in range(round(seconds * 10)):
            self.now += SECOND // 10
            self.interlocks.evaluate_all(self.now)

    def kinds(self, *wanted: str) -> list[str]:
        return [kind for kind, _ in self.notes if kind in wanted]


def test_a_closed_switch_that_lies_does_not_make_an_open_roof_closed_in_the_rain() -> None:
    roof = Roof()
    roof.rain = 1.0
    # The switch says closed; the position says wide open.
    roof.lasts(30, position=100.0)
    assert "dome/close" in roof.asked
    assert roof.kinds("enclosure_closed") == []
    alarms = [message for kind, message in roof.notes if kind == "enclosure_not_closed"]
    assert "sensors disagree (Closed switch: yes, Opening: 100 %)" in alarms[0]
    roof.lasts(5, position=0.4)
    assert roof.kinds("enclosure_closed") == ["enclosure_closed"]


def test_sensors_that_disagree_are_an_event_once_and_its_end_once() -> None:
    roof = Roof()
    roof.lasts(60)
    roof.notes.clear()
    # A switch that comes a little later than the position is no news.
    roof.lasts(9, **OPEN | {"closed": 1.0})
    roof.lasts(5, closed=0.0)
    assert roof.notes == []
    roof.lasts(120, closed=1.0)
    assert roof.notes == [
        (
            "enclosure_disagrees",
            "Dome: its sensors disagree, so it counts as not closed: "
            "Closed switch: yes, Opening: 100 %",
        )
    ]
    # One that falls silent has not come to agree.
    roof.lasts(30, position=None)
    assert roof.kinds("enclosure_agrees") == []
    roof.lasts(30, **CLOSED)
    assert [kind for kind, _ in roof.notes] == ["enclosure_disagrees", "enclosure_agrees"]


def closing_roof() -> Roof:
    """It rains, the roof was asked to close twice, and would be again in a tenth of a second."""
    roof = Roof()
    roof.rain = 1.0
    roof.lasts(5.9, **OPEN)
    roof.asked.clear()
    roof.notes.clear()
    return roof


def test_a_position_said_before_the_end_switch_turned_is_no_witness_against_it() -> None:
    roof = closing_roof()
    # The switch tells of the end at once; the position was said just before, and comes again.
    roof.said["position"] = roof.now
    for _ in range(5):
        roof.lasts(0.1, closed=1.0, position=4.0)
        # A dome that wants a heartbeat gets it: its sensors are read.
        assert roof.interlocks.enclosures.blind_reason("dome", roof.now) == ""
    assert roof.notes == []
    del roof.said["position"]
    roof.lasts(5, position=0.0)
    assert roof.kinds("enclosure_closed", "enclosure_retry") == ["enclosure_closed"]
    assert roof.asked == []


def test_a_position_said_after_the_end_switch_turned_is_a_witness_at_once() -> None:
    roof = closing_roof()
    roof.lasts(0.2, closed=1.0, position=4.0)
    assert roof.interlocks.enclosures.read_enclosure("dome", roof.now).disagree
    assert roof.asked == ["dome/close"]


def test_a_position_that_does_not_come_again_is_a_witness_after_two_seconds() -> None:
    roof = closing_roof()
    roof.said["position"] = roof.now
    roof.lasts(1.9, closed=1.0, position=4.0)
    assert roof.asked == []
    roof.lasts(0.5)
    assert roof.asked == ["dome/close"]
    assert roof.interlocks.enclosures.read_enclosure("dome", roof.now).disagree


def test_no_closing_waits_for_a_sensor_to_speak_again() -> None:
    roof = Roof()
    roof.lasts(30, **OPEN)
    # A switch turns in the moment in which rain begins.
    roof.said["position"] = roof.now
    roof.rain = 1.0
    roof.lasts(0.1, closed=1.0)
    assert roof.asked == ["dome/close"]


def test_a_closed_roof_whose_switch_says_open_is_asked_to_close_at_once() -> None:
    roof = Roof()
    roof.rain = 1.0
    roof.lasts(30)
    assert roof.asked == []
    roof.said["position"] = roof.now
    roof.lasts(0.1, closed=0.0)
    assert roof.kinds("enclosure_reopened") == ["enclosure_reopened"]
    assert roof.asked == ["dome/close"]


def test_the_shells_of_a_clamshell_settle_one_after_another() -> None:
    roof = Roof(CLAMSHELL)
    roof.rain = 1.0
    roof.lasts(5.9, **OPEN)
    roof.asked.clear()
    roof.said |= dict.fromkeys(("position", "west", "east"), roof.now)
    roof.lasts(0.3, closed=1.0)
    for name in ("west", "position", "east"):
        del roof.said[name]
        roof.lasts(0.1, **{name: 0.0})
        assert roof.interlocks.enclosures.blind_reason("dome", roof.now) == ""
    assert roof.asked == []
    assert roof.kinds("enclosure_closed", "enclosure_retry")[-1] == "enclosure_closed"


def test_an_alarm_about_sensors_does_not_end_while_they_settle() -> None:
    roof = Roof()
    roof.lasts(20, closed=1.0, position=100.0)
    assert roof.kinds("enclosure_disagrees") == ["enclosure_disagrees"]
    # The switch is silent, and speaks again before the position does.
    roof.said["position"] = roof.now
    roof.lasts(0.5, closed=None)
    roof.lasts(0.5, closed=1.0)
    assert roof.interlocks.enclosures.read_enclosure("dome", roof.now).disagree == ""
    del roof.said["position"]
    roof.lasts(20)
    assert roof.kinds("enclosure_disagrees", "enclosure_agrees") == ["enclosure_disagrees"]


@pytest.mark.parametrize("still_open", ["west", "east"])
def test_a_clamshell_is_closed_only_when_each_segment_is(still_open: str) -> None:
    roof = Roof(CLAMSHELL)
    roof.rain = 1.0
    roof.lasts(5, **OPEN)
    roof.lasts(30, **CLOSED | {still_open: 30.0})
    assert roof.kinds("enclosure_closed") == []
    assert roof.kinds("enclosure_disagrees") == ["enclosure_disagrees"]
    roof.lasts(30, **CLOSED)
    assert roof.kinds("enclosure_closed") == ["enclosure_closed"]


def test_sensors_that_disagree_raise_the_alarm_of_the_enclosure_in_fair_weather_too() -> None:
    roof = Roof()
    roof.lasts(9, closed=1.0, position=100.0)
    assert roof.problems == []
    roof.lasts(2)
    # Another number of the same contradiction is no news.
    roof.lasts(30, position=99.0)
    words = "Dome: its sensors disagree, so it counts as not closed: "
    assert roof.problems == [f"{words}Closed switch: yes, Opening: 100 %"]
    # A new link is told of what stands.
    roof.interlocks.link_up(roof.now)
    assert roof.problems.pop() == roof.problems[0]
    # Silence is no agreement.
    roof.lasts(20, position=None)
    assert len(roof.problems) == 1
    # It rains, and it cannot be closed: that is the worse news. Both end by themselves.
    roof.rain = 1.0
    roof.lasts(60, position=100.0)
    assert "NOT CLOSED" in roof.problems[-1]
    roof.rain = 0.0
    roof.lasts(1)
    assert roof.problems[-1] == roof.problems[0]
    roof.lasts(1, **CLOSED)
    assert roof.problems[-1] == ""


def test_a_flap_is_closed_too_and_by_its_own_command_only_while_it_is_open() -> None:
    roof = Roof(FLAP)
    roof.rain = 1.0
    roof.lasts(3, **OPEN)
    assert roof.asked[:2] == ["dome/close_flap", "dome/close"]
    # The shutter is closed and the flap is not: no contradiction, and not closed.
    roof.lasts(30, **CLOSED | {"flap": 0.0})
    assert roof.kinds("enclosure_closed", "enclosure_disagrees") == []
    roof.asked.clear()
    roof.lasts(60, **OPEN | {"flap": 1.0})
    assert set(roof.asked) == {"dome/close"}
    roof.lasts(30, **CLOSED)
    assert roof.kinds("enclosure_closed") == ["enclosure_closed"]


says = st.lists(st.sampled_from([True, False, None]), min_size=1, max_size=3).map(
    lambda said: [RoofSensor(each, str(each)) for each in said]
)


@given(says, st.dictionaries(st.sampled_from("we"), says), st.dictionaries(st.just("flap"), says))
def test_a_roof_is_closed_exactly_when_every_sensor_of_it_says_so(
    whole: list[RoofSensor],
    segments: dict[str, list[RoofSensor]],
    others: dict[str, list[RoofSensor]],
) -> None:
    every = [
        *whole,
        *(one for part in (segments, others) for some in part.values() for one in some),
    ]
    seen = closed_by(whole, segments, others, now_ns=0)
    assert (seen.closed is True) == all(one.closed is True for one in every)
    if seen.disagree:
        assert seen.closed is None
        assert {True, False} <= {one.closed for one in every}


def test_what_an_enclosure_can_do_follows_from_its_description() -> None:
    def can(text: str) -> Capabilities:
        site = load_site(text)
        return capabilities_of(site, site.enclosures["dome"])

    assert astuple(can(DESCRIPTION)) == (True, False, 1, False, False)
    assert astuple(can(CLAMSHELL)) == (True, False, 2, True, False)
    assert astuple(can(FLAP)) == (True, False, 1, False, True)
    assert can(DESCRIPTION + "    capabilities: {can_rotate: true}\n").can_rotate is True
    turns = (
        "      goto: {name: Turn, target: /g, type: a_msgs/srv/Turn,"
        " arguments: {azimuth: {type: number, field: az, unit: °}}}\ninterlocks:"
    )
    assert can(DESCRIPTION.replace("interlocks:", turns)).can_rotate is True


MISTAKES = [
    (DESCRIPTION, "below: 1}", "is: [closed]}", "closed[1].is", "a number has no states"),
    (DESCRIPTION, ", below: 1}", "}", "closed[1]", "compared with nothing"),
    (DESCRIPTION, 'is: ["yes"]', "below: 1", "closed[0].below", "neither above nor below"),
    (DESCRIPTION, "dome/position, b", "dome/postion, b", "closed[1].signal", "dome/postion"),
    (CLAMSHELL, "closed: [{signal: dome/west, below: 1}]", "closed: []", "west.closed", "nothing"),
    (CLAMSHELL, "position: dome/west", "position: dome/closed", "west.position", "dome/closed"),
    (DESCRIPTION, "retries: 2", "capabilities: {has_flap: true}", "has_flap", "nothing says when"),
    (DESCRIPTION, "retries: 2", "capabilities: {segments: 2}", "segments", "expected 1"),
    (FLAP, "retries: 2", "capabilities: {has_flap: false}", "has_flap", "flap is described"),
]


@pytest.mark.parametrize(("text", "was", "becomes", "where", "problem"), MISTAKES)
def test_a_mistake_in_an_enclosure_is_told(
    text: str, was: str, becomes: str, where: str, problem: str
) -> None:
    assert was in text
    findings = check_site(load_site(text.replace(was, becomes)))
    assert [one for one in findings if where in one.where and problem in one.problem], findings
