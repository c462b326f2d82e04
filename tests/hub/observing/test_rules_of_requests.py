"""Which state follows, what it costs, who may what: the rules of requests, held against tables."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from talaia.hub.auth.permissions import Grants, Permission, Right
from talaia.hub.observing.changes import (
    FAILURE_LIMIT,
    ImpossibleChange,
    change_request,
    observation_effect,
)
from talaia.hub.observing.charging import group_charge, request_charge
from talaia.hub.observing.proposal_access import ProposalRole, proposal_access
from talaia.hub.observing.quotas import ProposalLimits, TimeAccount, quota_problems
from talaia.model.observing.plan import Instrument
from talaia.model.observing.requests import (
    Configuration,
    ImageType,
    Request,
    RequestGroup,
    Urgency,
    Window,
)
from talaia.model.observing.states import (
    OBSERVATION_CHANGES,
    REQUEST_CHANGES,
    ObservationState,
    RequestState,
)
from talaia.model.observing.targets import IcrsTarget

STATES, TRIES = st.sampled_from(RequestState), st.sampled_from(ObservationState)


@given(STATES, STATES)
def test_a_request_changes_as_the_table_says_and_never_else(before, after) -> None:
    if after in REQUEST_CHANGES[before]:
        assert change_request(before, after, "why").after is after
    else:
        with pytest.raises(ImpossibleChange, match=f"{before.value} cannot become {after.value}"):
            change_request(before, after, "why")


@given(STATES, st.lists(TRIES, max_size=20))
def test_whatever_a_gateway_reports_each_step_is_one_of_the_table(state, reports) -> None:
    failures, was = 0, None
    for report in reports:
        effect = observation_effect(state, failures, before=was, after=report, why="so")
        for change in effect.changes:
            assert change.before is state
            assert change.after in REQUEST_CHANGES[state]
            state = change.after
        assert failures <= effect.failures <= failures + 1
        # One that cannot follow changes nothing.
        if was is not None and report is not was and report not in OBSERVATION_CHANGES[was]:
            assert effect == ((), failures)
            continue
        failures, was = effect.failures, report


def test_weather_and_people_count_no_failure_and_devices_do() -> None:
    for after in set(ObservationState) - {ObservationState.FAILED}:
        assert observation_effect(RequestState.PENDING, 1, before=None, after=after).failures == 1
    failed = observation_effect(
        RequestState.PENDING, FAILURE_LIMIT - 1, before=None, after=ObservationState.FAILED
    )
    assert [change.after for change in failed.changes] == [RequestState.FAILURE_LIMIT_REACHED]


def test_every_request_ends_completed_by_a_success_however_late() -> None:
    for state in set(RequestState) - {RequestState.COMPLETED}:
        effect = observation_effect(state, 0, before=None, after=ObservationState.COMPLETED)
        assert effect.changes[-1].after is RequestState.COMPLETED


def request(*configurations, target=True) -> Request:
    return Request(
        id="r",
        target=IcrsTarget(ra=10.0, dec=20.0) if target else None,
        configurations=configurations,
        windows=(Window(start=0.0, end=1.0),),
    )


def test_charge_counts_slew_centring_filters_exposures_and_readouts() -> None:
    instrument = Instrument(slew_rate=3.0, settle=3.0, acquire=20.0, filter_change=8.0, readout=5.0)
    light = Configuration(filter="R", exposure=60.0, count=10)
    again = Configuration(filter="R", exposure=10.0)
    other = Configuration(filter="B", exposure=10.0, count=3, dither=5.0)
    # 45° at 3°/s, 3 s and 20 s; two changes; 10·65; 15; 3·15 and two settlings.
    assert request_charge(request(light, again, other), instrument) == pytest.approx(
        15 + 3 + 20 + 2 * 8 + 650 + 15 + 45 + 6
    )
    dark = Configuration(type=ImageType.DARK, exposure=60.0, count=2)
    assert request_charge(request(dark, target=False), instrument) == 130.0
    group = RequestGroup(id="g", proposal="p", requests=(request(light), request(light)))
    assert group_charge(group, instrument) == 2 * request_charge(request(light), instrument)


def problems(*, charge=3600.0, limits=None, used=TimeAccount(), mine=TimeAccount(), **group):  # noqa: B008
    light = request(Configuration(exposure=1.0))
    asked = RequestGroup(id="g", proposal="p", requests=(light,), **group)
    return quota_problems(
        asked, charge, limits or ProposalLimits(hours=2.0), proposal=used, person=mine
    )


def test_quota_says_all_that_is_wrong_in_words() -> None:
    assert problems() == []
    assert problems(used=TimeAccount(3600.0, 0.0)) == []
    (said,) = problems(used=TimeAccount(1800.0, 1801.0))
    assert said.startswith("it is charged 1.00 h, and the proposal has 1.00 h left")
    mine = ProposalLimits(hours=9.0, person_hours=1.5, active=False)
    said = problems(
        limits=mine, mine=TimeAccount(1801.0), priority=50.0, urgency=Urgency.RAPID_RESPONSE
    )
    assert [one.partition(" ")[0] for one in said] == ["the", "priority", "this", "it"]
    rapid = ProposalLimits(hours=2.0, urgencies=frozenset({Urgency.RAPID_RESPONSE}))
    assert problems(limits=rapid, urgency=Urgency.RAPID_RESPONSE) == []


def grants(*rights: Right) -> Grants:
    return Grants(frozenset(Permission(right, "dome") for right in rights))


@pytest.mark.parametrize(
    ("rights", "role", "is_open", "may"),
    [
        ((), None, True, ""),
        ((Right.VIEW,), None, False, ""),
        ((Right.VIEW,), None, True, "sees"),
        # The right without the membership, and the membership without the right.
        ((Right.VIEW, Right.USE, Right.ARM, Right.REQUEST), None, False, ""),
        ((), ProposalRole.PRINCIPAL_INVESTIGATOR, False, "sees"),
        ((Right.REQUEST,), ProposalRole.MEMBER, False, "sees asks"),
        ((Right.REQUEST,), ProposalRole.PRINCIPAL_INVESTIGATOR, False, "sees asks leads"),
        ((Right.APPROVE,), None, False, "sees leads approves"),
        ((Right.ADMIN,), None, False, "sees leads approves"),
        ((Right.ADMIN,), ProposalRole.MEMBER, False, "sees asks leads approves"),
    ],
)
def test_who_may_what_with_a_proposal(rights, role, is_open, may) -> None:
    access = proposal_access(grants(*rights), "dome", role, is_open=is_open)
    assert " ".join(name for name, held in access._asdict().items() if held) == may
    elsewhere = proposal_access(grants(*rights), "moon", role, is_open=is_open)
    assert elsewhere[1:] == (False, False, False)
