"""What a rule makes of a notice, without a hub."""

from __future__ import annotations

import pytest

from talaia.hub.observing.alert_rules import (
    AlertRule,
    event_key,
    judge_notice,
    request_of_notice,
)
from talaia.model.observing.requests import Configuration, Urgency
from talaia.model.observing.states import RequestState
from talaia.wire.alerts.filters import AlertFilter
from talaia.wire.alerts.notice import AlertNotice

# 2026-11-23 02:00 UTC.
NOW = 1_795_399_200.0
NOTICE = AlertNotice(
    id="ivo://gcn/SWIFT#1", event="TrigID 1", source="gcn/SWIFT", ra=10.0, dec=20.0,
    error_radius=0.05, time="2026-11-23T01:00:00", parameters={"Rate_Signif": "9.5"},
)  # fmt: skip
RULE = AlertRule(
    name="bursts",
    filter=AlertFilter(sources=("*SWIFT*",), largest_error=0.1, least={"Rate_Signif": 7.0}),
    configurations=(Configuration(filter="R", exposure=60.0, count=3),),
    hours=6.0,
    priority=30.0,
)


def test_a_notice_that_passes_is_asked_for_until_so_many_hours_after_its_event() -> None:
    verdict = judge_notice(RULE, NOTICE, NOW)
    assert (verdict.window.start, verdict.window.end) == (NOW, NOW + 5 * 3600)
    assert verdict.why == (
        "its role is observation, it comes from gcn/SWIFT, its place is known to 0.05°,"
        " Rate_Signif is 9.5"
    )
    group = request_of_notice(
        RULE, NOTICE, verdict.window, proposal="P", requester="ada", state=RequestState.PENDING
    )
    (request,) = group.requests
    assert (group.urgency, group.priority, request.target.ra) == (Urgency.RAPID_RESPONSE, 30, 10)


@pytest.mark.parametrize(
    ("time", "why"),
    [("2026-11-22T19:00:00Z", "7.0 h old, more than 6 h"), ("2026-11-23T05:00:00", "in the fut")],
)
def test_what_was_too_long_ago_or_is_still_to_come_is_not_asked_for(time: str, why: str) -> None:
    old = judge_notice(RULE, AlertNotice(**{**_fields(NOTICE), "time": time}), NOW)
    assert old.window is None
    assert why in old.why


def test_a_retraction_asks_for_nothing_whatever_else_it_says() -> None:
    back = judge_notice(RULE, AlertNotice(**{**_fields(NOTICE), "retracts": True}), NOW)
    assert (back.window, back.why) == (None, "it takes its event back")


def test_the_same_number_of_another_mission_is_another_event() -> None:
    other = AlertNotice(**{**_fields(NOTICE), "source": "gcn/FERMI"})
    assert event_key(other) != event_key(NOTICE)


def _fields(notice: AlertNotice) -> dict[str, object]:
    return {name: getattr(notice, name) for name in notice.__struct_fields__}
