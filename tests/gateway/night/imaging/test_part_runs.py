"""Parts of a block that look at stars end within their bound, and say how."""

from __future__ import annotations

import asyncio

import pytest

from talaia.clock import SECOND, HandClock
from talaia.gateway.night.imaging.frame_reckoner import FrameReckoner
from talaia.gateway.night.imaging.part_runs import PartRuns
from talaia.gateway.night.imaging.star_parts import AbsentPart, FieldCentre, PartOutcome
from talaia.gateway.night.night_values import PartRun, StepAnswer
from talaia.wire.frames import CommandPhase

pytestmark = pytest.mark.pure


class Told:
    """Hears events."""

    def __init__(self) -> None:  # noqa: D107
        self.events: list[tuple[str, str]] = []

    def report_event(self, kind: str, message: str = "", **_: object) -> None:
        self.events.append((kind, message))


class Sky(AbsentPart):
    """Focuses, centres and guides as the test says; none: for ever."""

    present = True

    def __init__(self, outcome: PartOutcome | Exception | None) -> None:  # noqa: D107
        self.outcome, self.asked = outcome, list[object]()

    async def _end(self) -> PartOutcome:
        if isinstance(self.outcome, Exception):
            raise self.outcome
        return self.outcome if self.outcome is not None else await asyncio.Future()

    def is_due(self, filter_name: str, temperature: float | None, time: float) -> bool:
        self.asked.append((filter_name, temperature, time))
        return True

    async def run_focus(self, filter_name: str) -> PartOutcome:
        self.asked.append(filter_name)
        return await self._end()

    async def centre_field(self, centre: FieldCentre) -> PartOutcome:
        self.asked.append(centre)
        return await self._end()

    async def begin_guiding(self) -> PartOutcome:
        self.asked.append("guide")
        return await self._end()

    async def end_guiding(self) -> PartOutcome:
        self.asked.append("unguide")
        return PartOutcome(good=True)


def parts_of(sky: Sky, told: Told, clock: HandClock | None = None) -> PartRuns:
    clock = clock if clock is not None else HandClock()
    parts = PartRuns(clock=clock, events=told, reckoner=FrameReckoner(), guider=sky)
    parts.add_focuser(sky, lambda: 7.0)
    parts.add_solver(sky)
    return parts


async def answer_of(parts: PartRuns, part: str, within: float = 60.0) -> StepAnswer:
    came: asyncio.Future[StepAnswer] = asyncio.get_running_loop().create_future()
    parts.begin_part(PartRun("n1", part, within, "R", 40.0, 60.0), came.set_result)
    return await came


async def test_a_part_that_does_what_it_is_for_has_succeeded() -> None:
    sky, told = Sky(PartOutcome(good=True, message="centred to 2.0″")), Told()
    answer = await answer_of(parts_of(sky, told), "centre")
    assert answer == StepAnswer("n1", CommandPhase.SUCCEEDED, "centred to 2.0″")
    assert sky.asked == [FieldCentre(40.0, 60.0, filter="R")]
    assert told.events == []


async def test_a_part_that_fails_says_why_once() -> None:
    told = Told()
    parts = parts_of(Sky(PartOutcome(good=False, message="no stars")), told)
    for _ in range(2):
        answer = await answer_of(parts, "focus")
        assert answer == StepAnswer("n1", CommandPhase.FAILED, "no stars")
    assert told.events == [("night_part_failed", "focus: no stars")]


async def test_a_part_that_hangs_ends_within_its_bound() -> None:
    answer = await answer_of(parts_of(Sky(None), Told()), "centre", 0.02)
    assert answer == StepAnswer("n1", CommandPhase.FAILED, "no end after 0.02 s")


async def test_a_part_whose_process_died_has_failed_in_words() -> None:
    answer = await answer_of(parts_of(Sky(RuntimeError("it died")), Told()), "focus")
    assert answer == StepAnswer("n1", CommandPhase.FAILED, "it died")


async def test_a_block_that_is_broken_off_moves_nothing_more_and_ends_guiding() -> None:
    sky, answers = Sky(None), list[StepAnswer]()
    parts = parts_of(sky, Told())
    parts.begin_part(PartRun("n1", "guide", 60.0), answers.append)
    await asyncio.sleep(0)
    parts.end_block()
    await parts.close()
    assert sky.asked == ["guide", "unguide"]
    assert answers == []


def test_blocks_have_the_parts_that_are_there() -> None:
    none = PartRuns(clock=HandClock(), events=Told(), reckoner=FrameReckoner()).block_parts()
    assert (none.solves, none.guides, none.focus_due("R", 0.0)) == (False, False, False)
    sky = Sky(None)
    every = parts_of(sky, Told()).block_parts()
    assert (every.solves, every.guides, every.focus_due("R", 0.0)) == (True, True, True)
    assert sky.asked[0][:2] == ("R", 7.0)


async def test_the_seeing_is_that_of_the_last_centred_field_for_an_hour() -> None:
    clock = HandClock()
    parts = parts_of(Sky(PartOutcome(good=True, seeing=2.4)), Told(), clock)
    assert parts.latest_seeing() is None
    await answer_of(parts, "centre")
    clock.advance(3599 * SECOND)
    assert parts.latest_seeing() == 2.4
    clock.advance(2 * SECOND)
    # Nobody knows any more, so nothing is held back by it.
    assert parts.latest_seeing() is None
