"""Steps end: done, failed or refused, in bounded time and a bounded number of tries."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given, strategies as st

from talaia.gateway.night.night_values import NightCommand, NightView, StepAnswer
from talaia.gateway.night.step_runner import NightStep, StepRunner, StepsState
from talaia.wire.frames import CommandPhase

pytestmark = pytest.mark.pure
P = CommandPhase


def view(now: float, *, opened: bool | None = None) -> NightView:
    return NightView(now=now, time=now, sun=-30.0, opened=opened)


def runner(*steps: NightStep) -> StepRunner:
    count = itertools.count(1)
    return StepRunner(steps, lambda: f"c{next(count)}")


def test_a_sensor_that_shows_it_already_needs_no_command() -> None:
    steps = runner(NightStep(words="open", command="d/open", reached=lambda v: v.opened is True))
    assert steps.update_steps(view(0.0, opened=True)) == []
    steps.update_steps(view(0.1, opened=True))
    assert steps.state is StepsState.DONE


def test_a_word_that_no_sensor_bears_out_is_not_believed() -> None:
    steps = runner(
        NightStep(words="open", command="d/open", within=10.0, reached=lambda v: v.opened is True)
    )
    (asked,) = steps.update_steps(view(0.0))
    steps.take_answer(StepAnswer(asked.id, P.SUCCEEDED))
    steps.update_steps(view(5.0))
    assert steps.state is StepsState.RUNNING
    steps.update_steps(view(10.1))
    assert steps.state is StepsState.FAILED
    assert "sensors" in steps.why


def test_an_answer_to_an_earlier_try_is_passed_over() -> None:
    steps = runner(NightStep(words="slew", command="t/goto", within=5.0, tries=2))
    (first,) = steps.update_steps(view(0.0))
    steps.update_steps(view(5.1))
    (second,) = steps.update_steps(view(8.0))
    steps.take_answer(StepAnswer(first.id, P.SUCCEEDED))
    steps.update_steps(view(8.1))
    assert steps.state is StepsState.RUNNING
    steps.take_answer(StepAnswer(second.id, P.SUCCEEDED))
    steps.update_steps(view(8.2))
    steps.update_steps(view(8.3))
    assert steps.state is StepsState.DONE


def test_refused_is_not_failed_and_is_asked_again_only_for_what_makes_safe() -> None:
    plain = runner(NightStep(words="slew", command="t/goto", tries=3))
    (asked,) = plain.update_steps(view(0.0))
    plain.take_answer(StepAnswer(asked.id, P.REFUSED, "Rain"))
    plain.update_steps(view(0.1))
    assert plain.state is StepsState.REFUSED
    safe = runner(NightStep(words="close", command="d/close", tries=3, insists=True))
    (asked,) = safe.update_steps(view(0.0))
    safe.take_answer(StepAnswer(asked.id, P.REFUSED, "busy"))
    safe.update_steps(view(0.1))
    assert len(safe.update_steps(view(3.0))) == 1


@given(
    answers=st.lists(st.sampled_from([None, *sorted(set(P) - {P.ACCEPTED, P.RUNNING})])),
    tries=st.integers(1, 4),
    required=st.booleans(),
    insists=st.booleans(),
)
def test_whatever_is_answered_it_ends_and_asks_no_more_than_it_may(
    answers: list[CommandPhase | None], tries: int, *, required: bool, insists: bool
) -> None:
    step = NightStep(
        words="x", command="a/b", within=10.0, tries=tries, required=required, insists=insists
    )
    steps = runner(step, NightStep(words="rest", wait=3.0))
    given_answers, asked = iter(answers), 0
    for second in range(200):
        for command in steps.update_steps(view(float(second))):
            assert isinstance(command, NightCommand)
            asked += 1
            answer = next(given_answers, None)
            if answer is not None:
                steps.take_answer(StepAnswer(command.id, answer))
    assert steps.state is not StepsState.RUNNING
    assert asked <= tries
    if not required:
        assert steps.state is StepsState.DONE
