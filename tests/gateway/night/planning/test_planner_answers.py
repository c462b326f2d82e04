"""Idle time makes plans better and never late; what happens changes a plan and loses none."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np
import pytest
from msgspec.structs import replace
from night_observatory import EVENING, request

from talaia.gateway.night.planning.planner_answers import PlannerAnswers
from talaia.gateway.night.planning.planner_question import PlannerQuestion, PlannerSetup
from talaia.model.observing.plan import Instrument, VetoCause
from talaia.model.observing.requests import Proposal, RequestGroup
from talaia.model.observing.targets import FixedTarget, IcrsTarget
from talaia.planner.outlook import WeatherOutlook

if TYPE_CHECKING:
    from talaia.gateway.night.planning.planner_question import PlannerAnswer

pytest.importorskip("scipy")
pytestmark = pytest.mark.pure


def some_groups(seed: int, count: int) -> list[RequestGroup]:
    """Give requests all over the evening's sky, more than the night has room for."""
    dice = np.random.default_rng(seed)
    return [
        request(
            f"r{number}",
            target=IcrsTarget(ra=dice.uniform(0.0, 180.0), dec=dice.uniform(-10.0, 80.0)),
            frames=int(dice.integers(3, 20)),
            seconds=float(dice.choice((60.0, 120.0, 300.0))),
            priority=dice.uniform(5.0, 30.0),
        )
        for number in range(count)
    ]


def setup(groups: list[RequestGroup], hours_used: float = 0.0) -> PlannerSetup:
    school = Proposal(id="school", share=1.0, hours_allocated=40.0, hours_used=hours_used)
    return PlannerSetup(
        latitude=42.05, longitude=0.73, elevation=1568.0, instrument=Instrument(),
        proposals=(school,), groups=tuple(groups),
    )  # fmt: skip


def ask(answers: PlannerAnswers, number: int = 1, **more: object) -> PlannerAnswer:
    return answers.answer_question(PlannerQuestion(number=number, time=EVENING, **more))


def faded_worth(answer: PlannerAnswer, groups: list[RequestGroup]) -> float:
    """Give what a plan is worth where the roof may close: the planner's own measure."""
    assert answer.plan is not None
    worth = {
        one.id: group.priority * sum(part.exposure * part.count for part in one.configurations)
        for group in groups
        for one in group.requests
    }
    starts = np.array([block.start - EVENING for block in answer.plan.blocks])
    values = np.array([worth[block.request] for block in answer.plan.blocks])
    # Of the planner's minutes.
    weights = WeatherOutlook().weights(np.maximum(starts // 60 * 60, 0.0))
    return float((values * weights).sum()) / 60.0


def never() -> bool:
    return False


def test_the_first_target_is_chosen_from_where_the_telescope_is_parked() -> None:
    fixed = {
        "east": request("east", target=FixedTarget(altitude=40.0, azimuth=90.0)),
        "west": request("west", target=FixedTarget(altitude=40.0, azimuth=270.0)),
    }
    answers, other = PlannerAnswers(), PlannerAnswers()
    for one in (answers, other):
        one.take_setup(setup(list(fixed.values())))
    # Of the first question of a night, and of one behind a closing.
    assert ask(answers, parked=True, park=(40.0, 90.0)).request == "east"
    assert ask(answers, 2, parked=True, park=(40.0, 270.0)).request == "west"
    assert ask(other, parked=True, park=(40.0, 270.0)).request == "west"


def test_an_answer_after_idle_time_is_never_worse_than_the_first_and_often_better() -> None:
    better = 0
    for seed in (1, 2):
        groups, answers = some_groups(seed, 40), PlannerAnswers()
        answers.take_setup(setup(groups))
        worth = [faded_worth(ask(answers), groups)]
        while answers.improve_plan(never):
            worth.append(faded_worth(ask(answers), groups))
        worth.append(faded_worth(ask(answers), groups))
        # Starts are looked at by the minute.
        for earlier, later in itertools.pairwise(worth):
            assert later >= earlier * (1.0 - 1e-3), worth
        better += worth[-1] > worth[0] * 1.005
    assert better


def test_improving_gives_way_as_soon_as_somebody_asks_and_the_plan_stands() -> None:
    groups, answers, undisturbed = some_groups(1, 60), PlannerAnswers(), PlannerAnswers()
    asked = 0

    def looked_at() -> bool:
        nonlocal asked
        asked += 1
        return asked > 100

    for one in (answers, undisturbed):
        one.take_setup(setup(groups))
    first = ask(answers)
    assert answers.improve_plan(looked_at)
    # Once it has heard that somebody asks it has only come to its end: prices, two beams, the
    # choice and the round each look once more.
    assert asked <= 105
    assert faded_worth(ask(answers), groups) >= faded_worth(first, groups) * (1.0 - 1e-3)
    # A whole round looks many times, so that no piece of work between two looks is long.
    asked = -1_000_000
    ask(undisturbed)
    undisturbed.improve_plan(looked_at)
    assert asked + 1_000_000 > 400


def test_idle_time_is_used_a_bounded_number_of_times() -> None:
    answers = PlannerAnswers()
    assert not answers.improve_plan(never)
    answers.take_setup(setup(some_groups(2, 12)))
    ask(answers)
    rounds = 1
    while answers.improve_plan(never):
        rounds += 1
    assert rounds <= 5
    # The same question again is no reason to begin anew.
    ask(answers)
    assert not answers.improve_plan(never)


def test_a_new_set_of_requests_and_an_interruption_go_on_in_the_same_session() -> None:
    groups, answers = some_groups(3, 40), PlannerAnswers()
    answers.take_setup(setup(groups))
    first = ask(answers)
    answers.improve_plan(never)
    # Some frames were read out before rain came: the rest is a shorter block.
    begun = next(group for group in groups if group.id == f"g-{first.request}")
    count = begun.requests[0].configurations[0].count
    ask(answers, 2, done={first.request: (count - 1,)})
    assert answers.sessions == 1
    # The hub says what there is now: one is gone, one is new and urgent, hours were charged.
    new = request("new", priority=1000.0)
    left = [group for group in groups if group is not groups[0]]
    answers.take_setup(setup([*left, new], hours_used=1.0))
    told: dict[str, object] = {"done": {first.request: (count - 1,)}, "parked": True}
    ask(answers, 3, **told)
    while answers.improve_plan(never):
        pass
    answer = ask(answers, 4, **told)
    assert answers.sessions == 1
    assert answer.plan is not None
    planned = {block.request: block for block in answer.plan.blocks}
    assert "new" in planned
    assert groups[0].requests[0].id not in planned
    assert all(reason.request != groups[0].requests[0].id for reason in answer.why_not)
    if first.request in planned:
        block = planned[first.request]
        seconds = begun.requests[0].configurations[0].exposure
        assert block.end - block.start < 2 * seconds + 60.0
    # No hours left: nothing is planned.
    answers.take_setup(setup([*left, new], hours_used=40.0))
    assert ask(answers, 5).request == ""
    assert answers.sessions == 1


def test_what_is_another_request_by_the_same_name_begins_anew_from_the_former_plan() -> None:
    groups, answers = some_groups(4, 30), PlannerAnswers()
    answers.take_setup(setup(groups))
    while ask(answers) and answers.improve_plan(never):
        pass
    before = ask(answers)
    worthless = replace(groups[0], priority=0.01)
    answers.take_setup(setup([worthless, *groups[1:]]))
    after = ask(answers, 2)
    assert answers.sessions == 2
    assert before.plan is not None
    assert after.plan is not None
    # Most of what was planned for the evening is planned still, in the same order.
    kept = [block.request for block in before.plan.blocks]
    now = [block.request for block in after.plan.blocks if block.request in kept]
    pairs = list(itertools.pairwise(now))
    in_order = sum(kept.index(one) < kept.index(other) for one, other in pairs)
    assert in_order >= 0.6 * len(pairs)


def test_a_request_that_was_taken_back_and_asked_again_is_planned_again() -> None:
    groups, answers = [request("a", priority=50.0), request("b")], PlannerAnswers()
    answers.take_setup(setup(groups))
    assert ask(answers).request == "a"
    answers.take_setup(setup(groups[1:]))
    assert ask(answers, 2).request == "b"
    answers.take_setup(setup(groups))
    assert ask(answers, 3).request == "a"


def test_time_that_the_gateway_has_charged_itself_is_no_longer_there_to_be_planned() -> None:
    # Each takes three minutes and its readout; the proposal has forty hours.
    groups, answers = [request(f"r{n}", frames=3) for n in range(5)], PlannerAnswers()
    answers.take_setup(setup(groups))
    first = ask(answers)
    assert first.plan is not None
    assert len(first.plan.blocks) == 5
    # Seven minutes are left: two of them, interrupted ones, failed tries and darks counted.
    charged = {"school": 40 * 3600.0 - 420.0}
    later = ask(answers, 2, charged=charged)
    assert later.plan is not None
    assert len(later.plan.blocks) == 2
    # One of the two is done, and the time that it took is in what is charged: no more than one.
    done = ask(answers, 3, ended=(later.request,), charged={"school": 40 * 3600.0 - 210.0})
    assert done.plan is not None
    assert len(done.plan.blocks) == 1
    # A minute is left: nothing fits, and why is said.
    spent = ask(answers, 4, ended=(later.request,), charged={"school": 40 * 3600.0 - 60.0})
    assert spent.request == ""
    assert {one.cause for one in spent.why_not} == {VetoCause.ALLOCATION}
    assert answers.sessions == 1
    # A planner that was begun anew knows of it, too.
    anew = PlannerAnswers()
    anew.take_setup(setup(groups))
    assert ask(anew, 1, charged={"school": 40 * 3600.0}).request == ""
