"""Conditions, their delays, the quiet hours and the preview: values and times in, words out."""

from __future__ import annotations

import datetime as dt
import ipaddress
from zoneinfo import ZoneInfo

import msgspec
import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.clock import SECOND
from talaia.hub.alarms.condition_watch import ConditionTurn, ConditionWatch
from talaia.hub.alarms.conditions import (
    AlarmCondition,
    ConditionReading,
    ConditionVerdict,
    Truth,
    format_number,
)
from talaia.hub.alarms.preview import Track, preview_alarm
from talaia.hub.alarms.rules import Rule, due_us, rule_matches
from talaia.hub.alarms.state_machine import (
    Acknowledge,
    Assign,
    Clear,
    Happened,
    NotNow,
    Phase,
    Raise,
    Retire,
    Shelve,
    State,
    Unshelve,
    What,
    apply_event,
)
from talaia.hub.notify.address_policy import may_reach
from talaia.model.alarms.alarm import Alarm, AlarmKind, Severity
from talaia.model.checks.alarm_checks import Addresses
from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.load import load_site

pytestmark = pytest.mark.pure

SITE = """
talaia: 1
site: agv
name: AGV
ros2: {}
devices:
  base:
    name: Base
    signals:
      volts: {name: Battery, unit: V, max_age: 5, source: {topic: /v, type: a/msg/B, field: d}}
      door: {name: Door, type: state, states: [open, shut], source: {topic: /d, type: a/msg/B,
             field: d}}
    streams:
      eye: {name: Eye, source: {topic: /i, type: sensor_msgs/msg/Image}}
"""
LOW = Alarm(name="Low", kind=AlarmKind.LIMIT, signal="base/volts", below=11.0, hysteresis=0.5)


def judged(alarm: Alarm, *, held=False, **values: tuple[float, float]) -> ConditionVerdict:
    """Judge by value and age of each signal of the base."""
    condition = AlarmCondition(Addresses(load_site(SITE)), alarm)
    readings = {
        f"base/{name}": ConditionReading(value, "", age) for name, (value, age) in values.items()
    }
    return condition.judge_condition(readings, (), held=held, online=True)


YARD = SITE.replace(
    "devices:\n",
    """map:
  zones:
    yard:
      name: Yard
      geometry: {type: Polygon, coordinates: [[[2, 41], [2.001, 41], [2.001, 41.001], [2, 41.001],
                 [2, 41]]]}
devices:
""",
).replace(
    "    streams:",
    "      fix: {name: Fix, type: position, frame: wgs84, max_age: 5,\n"
    "            source: {topic: /f, type: sensor_msgs/msg/NavSatFix}}\n    streams:",
)


@pytest.mark.parametrize(
    ("lat", "lon", "age", "expected", "said"),
    [
        (41.0005, 2.0005, 0, Truth.FALSE, "Fix is inside Yard"),
        (41.0005, 2.0020, 0, Truth.HOLDS, "Fix is outside Yard"),
        (41.0005, 2.00099, 0, Truth.HOLDS, "Fix is less than 5 m from the edge of Yard"),
        (0.0, 0.0, 0, Truth.UNKNOWN, "Fix: farther than 100 km from Yard, so it is not believed"),
        (41.0005, 2.0020, 9, Truth.UNKNOWN, "Fix is 9.0 s old"),
        (float("nan"), 2.0020, 0, Truth.UNKNOWN, "Fix is not a number"),
    ],
)
def test_zone_holds_outside_or_near_its_edge_and_never_for_what_is_unknown(
    lat, lon, age, expected, said
) -> None:
    site = load_site(YARD)
    alarm = Alarm(name="Strayed", kind=AlarmKind.ZONE, signal="base/fix", outside="yard", margin=5)
    assert check_site(msgspec.structs.replace(site, alarms={"strayed": alarm})) == []
    condition = AlarmCondition(Addresses(site), alarm)
    assert condition.channels == ("base/fix.lat", "base/fix.lon")
    readings = {
        "base/fix.lat": ConditionReading(lat, "", age),
        "base/fix.lon": ConditionReading(lon, "", age),
    }
    verdict = condition.judge_condition(readings, (), held=False, online=True)
    assert verdict == (expected, said)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"signal": "base/volts"}, "base/volts"),
        ({"outside": "yrd"}, "yrd"),
        ({"inside": "yard"}, "both inside and outside"),
        ({"above": 3.0}, "an alarm of kind zone has no above"),
    ],
)
def test_check_says_what_a_zone_alarm_cannot_go_by(more, said) -> None:
    alarm = Alarm(name="Strayed", kind=AlarmKind.ZONE, signal="base/fix", outside="yard")
    site = msgspec.structs.replace(
        load_site(YARD), alarms={"strayed": msgspec.structs.replace(alarm, **more)}
    )
    assert any(said in str(one) for one in check_site(site))


def test_limit_says_why_and_lets_go_only_on_the_safe_side() -> None:
    assert judged(LOW, volts=(10.9, 0)) == (Truth.HOLDS, "Battery is 10.9 V, below 11 V")
    assert judged(LOW, volts=(11.2, 0)).truth is Truth.FALSE
    assert judged(LOW, held=True, volts=(11.2, 0)).truth is Truth.HOLDS
    assert judged(LOW, held=True, volts=(11.5, 0)).truth is Truth.FALSE


@pytest.mark.parametrize(
    ("value", "limits", "said"),
    [
        (96.8972351, [99.9], "96.9"),
        (10.99987, [11.0], "10.9999"),
        (1234567.8, [], "1234568"),
        (0.000123456, [], "0.0001235"),
        (3.0, [3.0], "3"),
    ],
)
def test_a_number_is_said_in_digits_that_people_read(
    value: float, limits: list[float], said: str
) -> None:
    assert format_number(value, limits) == said


numbers = st.floats(allow_nan=False, allow_infinity=False)


@given(numbers, st.lists(numbers, max_size=2))
def test_what_is_said_of_a_number_stands_where_it_does_to_its_limits(
    value: float, limits: list[float]
) -> None:
    said = float(format_number(value, limits))
    assert [(said > each, said < each) for each in limits] == [
        (value > each, value < each) for each in limits
    ]


def test_what_is_not_known_is_neither_true_nor_false() -> None:
    assert judged(LOW) == (Truth.UNKNOWN, "Battery has never been heard of")
    assert judged(LOW, volts=(10.0, 6.0)) == (Truth.UNKNOWN, "Battery is 6.0 s old")
    assert judged(LOW, volts=(float("nan"), 0)) == (Truth.UNKNOWN, "Battery is not a number")


def test_state_compares_by_its_name_and_stale_by_its_age() -> None:
    shut = Alarm(name="Shut", kind=AlarmKind.STATE, signal="base/door", is_not=("open",))
    assert judged(shut, door=(1, 0)) == (Truth.HOLDS, "Door is 'shut'")
    assert judged(shut, door=(0, 0)).truth is Truth.FALSE
    stale = Alarm(name="Stale", kind=AlarmKind.STALE, signal="base/volts", max_age=2.0)
    assert judged(stale, volts=(1, 1.9)).truth is Truth.FALSE
    assert judged(stale, volts=(1, 2.1)).truth is Truth.HOLDS
    assert judged(stale).truth is Truth.HOLDS


HOLDS, FALSE = ConditionVerdict(Truth.HOLDS, "so"), ConditionVerdict(Truth.FALSE, "not so")
UNKNOWN = ConditionVerdict(Truth.UNKNOWN, "who knows")


def turns(
    alarm: Alarm, *story: tuple[float, ConditionVerdict], on=False
) -> list[tuple[float, ConditionTurn]]:
    """Tell what a watch makes of what was so at each second."""
    watch, found = ConditionWatch(alarm, on=on), []
    for at_s, verdict in story:
        edge = watch.update_verdict(verdict, round(at_s * SECOND))
        if edge:
            found.append((at_s, edge.turn))
    return found


def test_what_is_true_for_less_than_the_delay_raises_nothing() -> None:
    slow = Alarm(name="Slow", kind=AlarmKind.STALE, delay=5.0, clear_delay=3.0)
    assert turns(slow, (0, HOLDS), (4.9, HOLDS), (4.95, FALSE), (6, HOLDS), (10.9, HOLDS)) == []
    assert turns(slow, (0, HOLDS), (5, HOLDS), (6, FALSE), (8.9, FALSE), (9, FALSE)) == [
        (5, ConditionTurn.RAISE),
        (9, ConditionTurn.CLEAR),
    ]


def test_what_is_unknown_clears_nothing_and_raises_only_where_that_is_wanted() -> None:
    plain = Alarm(name="Plain", kind=AlarmKind.STALE, clear_delay=3.0)
    assert turns(plain, (0, UNKNOWN), (1e6, UNKNOWN)) == []
    story = ((0, FALSE), (2, UNKNOWN), (4, FALSE), (6.9, FALSE), (7, FALSE))
    assert turns(plain, *story, on=True) == [(7, ConditionTurn.CLEAR)]
    careful = Alarm(name="Careful", kind=AlarmKind.STALE, unknown_after=10.0)
    assert turns(careful, (0, UNKNOWN), (9.9, UNKNOWN), (10, UNKNOWN)) == [
        (10, ConditionTurn.RAISE)
    ]


def walk(*events) -> tuple[State, list[Happened]]:
    state, all_of_it = State(), []
    for event in events:
        state, happened = apply_event(state, event)
        all_of_it += happened
    return state, all_of_it


def test_alarm_that_is_over_waits_to_be_acknowledged() -> None:
    state, happened = walk(Raise(1, "low"), Raise(2, "low"), Clear(3, "well"))
    assert state.phase is Phase.CLEARED
    assert [each.what for each in happened] == [What.RAISED, What.CLEARED]
    state, _ = apply_event(state, Acknowledge(4, "ada"))
    assert (state.phase, state.acked_by) == (Phase.NORMAL, "ada")
    with pytest.raises(NotNow, match="ada has acknowledged it"):
        apply_event(state, Acknowledge(5, "bob"))


def test_acknowledged_alarm_that_is_over_is_well_and_a_new_one_is_another_episode() -> None:
    state, happened = walk(
        Raise(1, "low"), Assign(2, "ada", "bob"), Acknowledge(3, "ada"), Clear(4, ""), Raise(5, "")
    )
    assert (state.phase, state.episode, state.acked_by, state.assigned) == (
        Phase.ACTIVE,
        2,
        "",
        "",
    )
    assert [each.episode for each in happened if each.what is What.RAISED] == [1, 2]


def test_nobody_is_told_of_a_shelved_alarm_until_the_shelving_is_over() -> None:
    state, happened = walk(Shelve(1, "ada", 100, "known"), Raise(2, "low"))
    assert not any(each.tell for each in happened)
    _, over = apply_event(state, Unshelve(100))
    assert over[0].tell
    assert over[0].message == "low"
    with pytest.raises(NotNow, match="not in the future"):
        apply_event(State(), Shelve(5, "ada", 5, ""))


def test_alarm_that_is_described_no_more_stands_no_more() -> None:
    state, happened = walk(Raise(1, "low"), Retire(2))
    assert (state.phase, happened[-1].what) == (Phase.NORMAL, What.RETIRED)
    assert apply_event(state, Retire(3)) == (state, ())


def rule(**changes) -> Rule:
    said = {
        "id": 1, "user": 1, "site": "*", "way": 1, "target": "", "least": Severity.WARNING,
        "over": True, "quiet_from": 22 * 60, "quiet_to": 7 * 60,
        "quiet_least": Severity.CRITICAL, "zone": "Europe/Madrid", "group_s": 0,
    }  # fmt: skip
    return Rule(**{**said, **changes})


def at(text: str, zone: str = "Europe/Madrid") -> int:
    return round(dt.datetime.fromisoformat(text).replace(tzinfo=ZoneInfo(zone)).timestamp() * 1e6)


@pytest.mark.parametrize(
    ("now", "due"),
    [
        ("2026-01-10T12:00", "2026-01-10T12:00"),
        ("2026-01-10T21:59", "2026-01-10T21:59"),
        ("2026-01-10T22:00", "2026-01-11T07:00"),
        ("2026-01-11T06:59", "2026-01-11T07:00"),
        ("2026-01-11T07:00", "2026-01-11T07:00"),
        # The clock is put forward at 2:00 and back at 3:00; seven is seven all the same.
        ("2026-03-28T23:00", "2026-03-29T07:00"),
        ("2026-10-24T23:00", "2026-10-25T07:00"),
    ],
)
def test_quiet_hours_are_those_of_the_persons_own_clock(now, due) -> None:
    assert due_us(rule(), Severity.WARNING, at(now)) == at(due)
    assert due_us(rule(), Severity.CRITICAL, at(now)) == at(now)
    assert due_us(rule(quiet_to=22 * 60), Severity.WARNING, at(now)) == at(now)


def test_rule_wants_what_is_bad_enough_of_its_site() -> None:
    raised = Happened(What.RAISED, 1, 0, "", "", tell=True)
    cleared = raised._replace(what=What.CLEARED)
    assert rule_matches(rule(), "agv", Severity.WARNING, raised)
    assert not rule_matches(rule(), "agv", Severity.INFO, raised)
    assert not rule_matches(rule(site="moon"), "agv", Severity.WARNING, raised)
    assert not rule_matches(rule(over=False), "agv", Severity.WARNING, cleared)
    assert not rule_matches(rule(), "agv", Severity.WARNING, raised._replace(tell=False))


def test_preview_counts_what_would_have_been() -> None:
    times = np.arange(0, 100_000_000, 1_000_000)
    values = np.where((times // 10_000_000) % 2 == 0, 12.0, 10.0)
    slow = Alarm(name="Low", kind=AlarmKind.LIMIT, signal="base/volts", below=11.0, delay=4.0)
    tracks = {"base/volts": Track(times, values, {}, 0)}
    said = preview_alarm(AlarmCondition(Addresses(load_site(SITE)), slow), tracks, 0, 110_000_000)
    assert said.times == 5
    assert (said.spans[0].from_us, said.spans[0].to_us) == (14_000_000, 20_000_000)
    # Its last value is five seconds good.
    assert said.unknown_us == pytest.approx(6_000_000, abs=10)


@pytest.mark.parametrize(
    ("written", "where", "problem"),
    [
        ("{name: A, kind: limit, signal: base/volts}", "$.alarms.a", "there is no limit"),
        ("{name: A, kind: limit, signal: base/vols, above: 1}", "$.alarms.a.signal", "'base/vols'"),
        ("{name: A, kind: state, signal: base/door, is: [ajar]}", "$.alarms.a.is[0]", "'ajar'"),
        ("{name: A, kind: stale, signal: base/door, above: 1}", "$.alarms.a.above", "has no above"),
        ("{name: A, kind: detection, stream: base/ey, label: dog}", "$.alarms.a.stream", "ey"),
        ('{name: A, kind: expression, expression: "1 > 2"}', "$.alarms.a.expression", "no signal"),
        ('{name: A, kind: expression, expression: "1 >"}', "$.alarms.a.expression", "at letter 4"),
        ("{name: A, kind: limit, signal: base/volts, above: 1, below: 2}", "$.alarms.a.below", "2"),
    ],
)
def test_description_tells_what_does_not_fit_in_an_alarm(written, where, problem) -> None:
    findings = check_site(load_site(f"{SITE}alarms:\n  a: {written}\n"))
    assert [finding.where for finding in findings] == [where]
    assert problem in findings[0].problem


@pytest.mark.parametrize(
    "address",
    [
        "127.0.0.1", "10.0.0.1", "192.168.1.1", "169.254.169.254", "0.0.0.0", "224.0.0.1",  # noqa: S104 - refused
        "255.255.255.255", "::1", "fe80::1%eth0", "fc00::1", "::ffff:127.0.0.1", "ff02::1",
        "64:ff9b::7f00:1", "2002:7f00:1::", "100.64.0.1", "nonsense",
    ],
)  # fmt: skip
def test_address_that_only_the_hub_can_reach_is_refused(address) -> None:
    assert not may_reach(address, [])


def test_public_address_and_named_network_are_reached() -> None:
    named = [ipaddress.ip_network("10.0.0.0/24")]
    assert may_reach("1.1.1.1", [])
    assert may_reach("2606:4700::1111", [])
    assert may_reach("10.0.0.7", named)
    assert not may_reach("10.0.1.7", named)


def test_a_message_is_in_the_unit_that_the_site_chose() -> None:
    site = load_site(SITE + "shown_units: {V: mV}\n")
    condition = AlarmCondition(Addresses(site), LOW)
    readings = {"base/volts": ConditionReading(10.9, "", 0)}
    judged_so = condition.judge_condition(readings, (), held=False, online=True)
    assert judged_so == (Truth.HOLDS, "Battery is 10900 mV, below 11000 mV")
