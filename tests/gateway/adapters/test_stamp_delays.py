"""A signal that keeps the arrivals of messages beside the stamps that their samples have."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from talaia.gateway.adapters.connection_scope import scopes_of
from talaia.gateway.adapters.topic_readers import SampleBuffer, TopicPlan, plans_of
from talaia.gateway.samples.header_times import HeaderTimes
from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.load import load_site

pytestmark = pytest.mark.pure

SITE = """
talaia: 1
site: s
name: S
ros2: {}
devices:
  base:
    name: Base
    signals:
      rate: {name: Rate, source: {topic: /imu, type: sensor_msgs/msg/Imu, field: x}}
      late:
        name: Delay
        unit: s
        RULE
        source: {topic: /imu, type: sensor_msgs/msg/Imu, delay: true}
"""
NOW_US = 1_700_000_000_000_000


def plan_of(rule: str, times: HeaderTimes | None) -> TopicPlan:
    (scope,) = scopes_of(load_site(SITE.replace("RULE", rule)))
    make = None if times is None else lambda: times
    (plan,) = plans_of(scope, {}, lambda *_: None, header_times=make)
    return plan


def heard(plan: TopicPlan, *late_ms: int | None) -> list[tuple[int, int, float]]:
    """Give samples as channel, time before the arrival of the last message (ms), value."""
    into = SampleBuffer()
    for at, late in enumerate(late_ms):
        arrived_us = NOW_US + at * 100_000
        header = None
        if late is not None:
            stamp_us = arrived_us - late * 1000
            stamp = SimpleNamespace(sec=stamp_us // 10**6, nanosec=stamp_us % 10**6 * 1000)
            header = SimpleNamespace(stamp=stamp)
        plan.read_message(SimpleNamespace(x=float(at), header=header), arrived_us, 1, into)
    columns = into.take_columns()
    assert columns is not None
    last_us = NOW_US + (len(late_ms) - 1) * 100_000
    return [
        (int(channel), round((last_us - int(time)) / 1000), round(float(value), 6))
        for channel, time, value in zip(
            columns.channel, columns.time_us, columns.value, strict=True
        )
    ]


def test_stamp_and_arrival_are_both_kept() -> None:
    assert check_site(load_site(SITE.replace("RULE", ""))) == []
    found = heard(plan_of("", HeaderTimes()), 40)
    # The sample has the time of its stamp; that and the delay make the arrival.
    assert found == [(0, 40, 0.0), (1, 40, 0.04)]


def test_where_stamp_and_arrival_agree_the_delay_is_zero() -> None:
    assert heard(plan_of("", HeaderTimes()), None) == [(0, 0, 0.0), (1, 0, 0.0)]
    # A stamp of another year is not believed: the sample has the arrival, and no delay.
    assert heard(plan_of("", HeaderTimes()), 10**8) == [(0, 0, 0.0), (1, 0, 0.0)]


def test_with_a_deadband_only_what_changes_is_kept() -> None:
    plan = plan_of("deadband: 0.005", HeaderTimes())
    found = heard(plan, 40, 42, 41, 39, 70, 71)
    assert [value for channel, _, value in found if channel == 1] == [0.04, 0.07]
    assert len([1 for channel, *_ in found if channel == 0]) == 6


def test_what_is_imported_has_one_time_and_no_delay() -> None:
    assert heard(plan_of("", None), 40) == [(0, 0, 0.0)]


@pytest.mark.parametrize(
    ("rule", "source", "why"),
    [
        ("type: text", "delay: true", "a delay is a number of seconds, and no text"),
        ("unit: ms", "delay: true", "a delay is in seconds"),
        ("unit: s", "delay: true, field: x", "field is given, too"),
        ("unit: s", "delay: true, stamp: header.stamp", "a delay has no stamp"),
    ],
)
def test_a_delay_of_something_else_is_refused(rule: str, source: str, why: str) -> None:
    text = SITE.replace("        unit: s\n", "").replace("RULE", rule)
    found = [str(one) for one in check_site(load_site(text.replace("delay: true", source)))]
    assert any(why in one for one in found), found
