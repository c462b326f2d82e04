"""A roof that must be closed, against worlds in which everything may go wrong."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import msgspec
import pytest
from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.clock import SECOND
from talaia.gateway.safety.enclosure_guard import (
    EnclosureAction,
    EnclosureEvent,
    EnclosureGuard,
    EnclosureReadings,
)
from talaia.model.interlocks.enclosure import (
    ClosingOrder,
    Enclosure,
    PastDeadline,
    Sighting,
)
from talaia.model.interlocks.interlock import Step
from talaia.model.interlocks.opening import opening_of
from talaia.model.yaml_text.load import load_site

pytestmark = pytest.mark.pure

EXAMPLES = Path(__file__).parents[3] / "examples"
YES = ("yes",)
RULE = Enclosure(
    name="Dome",
    unsafe=("rain",),
    closed=(Sighting(signal="dome/closed", is_one_of=YES),),
    close=Step(command="dome/close"),
    stop="dome/stop",
    abort=(Step(command="camera/abort"),),
    park=Step(command="telescope/park"),
    parked=Sighting(signal="telescope/parked", is_one_of=YES),
    mount_within=30,
    move_within=20,
    retries=3,
    alarm_every=60,
)
TICK = SECOND // 10


@dataclass
class World:
    """A roof of 10 s and a telescope of 5 s, and what was asked of them."""

    guard: EnclosureGuard
    now: int = 0
    position: float = 1.0
    closing: bool = False
    opening: bool = False
    deaf_to_stop: bool = False
    parked: bool = False
    parking: bool = False
    stuck: bool = False
    mount_stuck: bool = False
    blind: bool = False
    deaf: bool = False
    why: str = ""
    asked: list[tuple[float, str]] = field(default_factory=list)
    said: list[tuple[str, str]] = field(default_factory=list)
    parked_ns: int = 0

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds * 10)):
            self.now += TICK
            self._move()
            closed = None if self.blind else self.position <= 0
            seen = EnclosureReadings(closed, self.closing, self.parked, self.opening)
            self.do(self.guard.update_enclosure(self.why, seen, self.now))

    def _move(self) -> None:
        if self.closing and not self.stuck:
            self.position = max(0.0, self.position - 0.01)
            self.closing = self.position > 0
        elif self.stuck:
            self.closing = False
        if self.opening:
            self.position = min(1.0, self.position + 0.01)
            self.opening = self.position < 1
        if self.parking and not self.mount_stuck:
            self.parked_ns += TICK
            self.parked = self.parked_ns >= 5 * SECOND

    def do(self, acts: list[EnclosureAction | EnclosureEvent]) -> None:
        for act in acts:
            if isinstance(act, EnclosureEvent):
                self.said.append((act.kind, act.message))
                continue
            self.asked.append((self.now / SECOND, act.step.command))
            assert not act.step.required
            if self.deaf:
                continue
            if act.step.command == "dome/close":
                self.closing, self.opening = True, False
            if act.step.command == "dome/stop" and not self.deaf_to_stop:
                self.closing = self.opening = False
            if act.step.command == "telescope/park":
                self.parking = True

    def times(self, command: str) -> list[float]:
        return [at for at, what in self.asked if what == command]

    def kinds(self) -> list[str]:
        return [kind for kind, _ in self.said]


def world(**changes: object) -> World:
    return World(EnclosureGuard("dome", msgspec.structs.replace(RULE, **changes)))


def test_while_all_is_safe_nothing_is_asked() -> None:
    one = world()
    one.run(100)
    assert (one.asked, one.said) == ([], [])


def test_unsafe_aborts_then_parks_then_closes_and_success_is_the_switch() -> None:
    one = world()
    one.why = "Rain"
    one.run(30)
    assert [what for _, what in one.asked] == ["camera/abort", "telescope/park", "dome/close"]
    assert one.times("dome/close")[0] >= 5
    assert one.kinds() == ["enclosure_closes", "enclosure_closed"]
    assert one.position == 0


def test_the_roof_waits_for_the_telescope_but_not_for_ever() -> None:
    one = world()
    one.mount_stuck = True
    one.why = "Rain"
    one.run(29)
    assert one.times("dome/close") == []
    one.run(20)
    assert one.position == 0
    # Ever again, though not at every look.
    assert 3 <= len(one.times("telescope/park")) <= 5


def test_where_the_description_says_so_it_stays_open_and_cries_instead() -> None:
    one = world(past_deadline=PastDeadline.ALARM)
    one.mount_stuck = True
    one.why = "Rain"
    one.run(150)
    assert one.times("dome/close") == []
    assert one.kinds().count("enclosure_not_closed") == 2
    assert "telescope is not parked" in one.said[-1][1]


def test_parallel_asks_for_both_at_once() -> None:
    one = world(order=ClosingOrder.PARALLEL)
    one.why = "Rain"
    one.run(1.2)
    assert [what for _, what in one.asked] == ["camera/abort", "dome/close", "telescope/park"]


def test_close_first_parks_when_the_roof_is_closed() -> None:
    one = world(order=ClosingOrder.CLOSE_FIRST)
    one.why = "Rain"
    one.run(30)
    assert [what for _, what in one.asked] == ["camera/abort", "dome/close", "telescope/park"]
    assert one.times("telescope/park")[0] >= 9.9


def test_a_stuck_shutter_is_retried_with_growing_pauses_and_then_an_alarm_is_repeated() -> None:
    one = world(park=None, parked=None)
    one.stuck = True
    one.why = "Rain"
    one.run(200)
    asked = one.times("dome/close")
    pauses = [round(later - before) for before, later in pairwise(asked)]
    assert pauses[:4] == [2, 4, 8, 16]
    assert max(pauses) == 30
    assert one.guard.alarmed
    cried = [message for kind, message in one.said if kind == "enclosure_not_closed"]
    assert "NOT CLOSED after 3 tries" in cried[0]
    assert len(cried) == 4
    one.stuck = False
    one.run(60)
    assert one.position == 0
    assert "alarm_over" in one.kinds()
    assert not one.guard.alarmed


def test_a_roof_whose_sensors_say_nothing_counts_as_open() -> None:
    one = world()
    one.position, one.blind, one.parked = 0.0, True, True
    one.why = "Rain"
    one.run(60)
    assert len(one.times("dome/close")) > 3
    assert any("its sensors say nothing" in message for _, message in one.said)


def test_a_roof_that_somebody_opens_is_asked_to_close_at_once() -> None:
    one = world()
    one.why = "Rain"
    one.run(30)
    count = len(one.times("dome/close"))
    one.position = 0.5
    at = one.now / SECOND
    one.run(10)
    assert one.times("dome/close")[count] - at <= 0.2
    assert one.position == 0
    assert "enclosure_reopened" in one.kinds()


@pytest.mark.parametrize("name", ["observatory", "indi"])
def test_a_description_that_has_a_state_opening_need_not_say_so(name: str) -> None:
    site = load_site((EXAMPLES / name / "site.yaml").read_text())
    dome = site.enclosures["dome"]
    by_default = Sighting(signal="dome/shutter", is_one_of=("opening",))
    assert opening_of(site, dome) == (by_default,)
    said = Sighting(signal="dome/shutter", is_one_of=("open",))
    assert opening_of(site, msgspec.structs.replace(dome, opening=(said,))) == (said,)


@pytest.mark.parametrize("order", list(ClosingOrder))
@pytest.mark.parametrize("stop", ["dome/stop", ""])
def test_a_roof_that_opens_when_it_becomes_unsafe_opens_no_further(
    order: ClosingOrder, stop: str
) -> None:
    one = world(order=order, stop=stop)
    one.position, one.opening = 0.2, True
    one.run(1)
    began = one.position
    one.why = "Rain"
    one.run(0.3)
    assert one.position <= began + 0.011
    assert not one.opening
    waits = order is ClosingOrder.MOUNT_FIRST and stop
    assert [what for _, what in one.asked if what.startswith("dome")] == [
        "dome/stop" if waits else "dome/close"
    ]
    assert "enclosure_turned" in one.kinds()
    one.run(30)
    assert one.position == 0
    if waits:
        # Stopped it stands beside the telescope, and closes in its order.
        assert one.times("dome/close")[0] >= one.times("telescope/park")[0] + 5


def test_a_roof_that_goes_on_opening_in_spite_of_stop_is_turned() -> None:
    one = world()
    one.position, one.opening, one.deaf_to_stop = 0.2, True, True
    one.why = "Rain"
    one.mount_stuck = True
    one.run(10)
    assert one.position == 0
    assert [what for _, what in one.asked if what.startswith("dome")] == ["dome/stop", "dome/close"]


def test_a_roof_that_obeys_nothing_is_not_asked_at_every_look() -> None:
    one = world()
    one.position, one.opening, one.deaf, one.why = 0.0001, True, True, "Rain"
    one.run(9)
    asked = [at for at, what in one.asked if what in ("dome/stop", "dome/close")]
    assert all(later - at >= 2 for at, later in pairwise(asked))
    assert len(asked) >= 3


def test_a_closed_roof_is_left_alone_and_darks_go_on() -> None:
    one = world()
    one.position, one.parked = 0.0, True
    one.why = "Rain"
    one.run(100)
    assert one.asked == []


def test_nobody_is_asked_at_every_look() -> None:
    one = world()
    one.deaf = True
    one.why = "Rain"
    one.run(600)
    assert len(one.asked) < 60


def test_a_stop_by_a_person_holds_the_closing_with_an_alarm_until_a_person_resumes_it() -> None:
    one = world(park=None, parked=None)
    one.why = "Rain"
    one.run(3)
    one.closing = False
    one.do(one.guard.handle_command("dome/stop", "Ada"))
    count = len(one.times("dome/close"))
    one.run(70)
    assert len(one.times("dome/close")) == count
    cried = [message for kind, message in one.said if kind == "enclosure_not_closed"]
    assert len(cried) == 2
    assert "stopped by Ada" in cried[0]
    one.do(one.guard.handle_command("dome/close", "Ada"))
    one.closing = True
    one.run(20)
    assert one.position == 0
    assert one.kinds()[-3:] == ["enclosure_resumed", "enclosure_closed", "alarm_over"]


things = st.tuples(
    st.sampled_from(
        ["rain", "dry", "stuck", "free", "blind", "sees", "deaf", "hears", "mount", "open", "stop"]
    ),
    st.integers(1, 120),
)


@given(
    st.lists(things, max_size=25),
    st.sampled_from(ClosingOrder),
    st.sampled_from([PastDeadline.CLOSE]),
)
@settings(max_examples=examples(15, many=600), deadline=None)
def test_whatever_happened_before_once_all_works_again_the_roof_closes_within_its_bound(
    history: list[tuple[str, int]], order: ClosingOrder, past: PastDeadline
) -> None:
    one = world(order=order, past_deadline=past)
    for what, seconds in history:
        match what:
            case "rain" | "dry":
                one.why = "Rain" if what == "rain" else ""
            case "stuck" | "free":
                one.stuck = what == "stuck"
            case "blind" | "sees":
                one.blind = what == "blind"
            case "deaf" | "hears":
                one.deaf = what == "deaf"
            case "mount":
                one.mount_stuck = not one.mount_stuck
            case "open":
                one.position, one.closing = 1.0, False
            case "stop":
                one.closing = False
        one.run(seconds)
    one.why, one.stuck, one.blind, one.deaf = "Rain", False, False, False
    # The longest pause between two tries, the wait for the telescope, and the way itself.
    one.run(30 + 30 + 20)
    assert one.position == 0
    closes = one.times("dome/close")
    assert len(closes) <= 3 + one.now / SECOND / 2
