"""The judge of nights sees what it is there for."""

from __future__ import annotations

from talaia.gateway.night.observation_book import MOST_WAITING
from talaia.model.observing.states import ObservationState
from talaia.wire.frames import ObservationUpdate

from .judge import judge_numbers, judge_roof
from .sky_robot import Truth

FINE = Truth(
    at=0.0, sun=-30.0, roof="closed", telescope="parked", camera="idle", cooling=False, rain=0.0,
    wind=8.0, gust=10.0, humidity=45.0, dew_gap=10.0, clouds=5.0, weather_silent=False,
    roof_dead=False, local=False,
)  # fmt: skip


def ledger(*spans: tuple[int, Truth]) -> list[Truth]:
    """Give an entry for each second of spans that follow each other."""
    entries: list[Truth] = []
    for seconds, one in spans:
        entries += [one._replace(at=float(len(entries) + n)) for n in range(seconds)]
    return entries


def test_an_open_roof_in_the_rain_is_wrong_once_closing_would_have_been_done() -> None:
    opened, wet = FINE._replace(roof="open"), FINE._replace(roof="open", rain=1.0)
    assert judge_roof(ledger((60, opened), (60, wet), (60, FINE)), []) == []
    assert len(judge_roof(ledger((60, opened), (120, wet)), [])) == 1


def test_a_roof_that_begins_to_open_in_the_rain_is_wrong_at_once() -> None:
    opening = FINE._replace(roof="opening", rain=1.0)
    entries = ledger((20, FINE._replace(rain=1.0)), (5, opening), (5, FINE))
    assert len(judge_roof(entries, [])) == 1
    # But not where somebody at the dome does it.
    assert judge_roof(entries, [(20.0, 35.0)]) == []


def test_what_is_not_known_is_unsafe() -> None:
    blind = FINE._replace(roof="open", weather_silent=True)
    assert len(judge_roof(ledger((200, blind)), [])) == 1


def test_a_roof_that_cannot_move_is_not_blamed_and_has_its_time_afterwards() -> None:
    stuck = FINE._replace(roof="open", rain=1.0, roof_dead=True)
    loose = FINE._replace(roof="open", rain=1.0)
    assert judge_roof(ledger((300, stuck), (60, loose), (30, FINE)), []) == []
    assert len(judge_roof(ledger((300, stuck), (120, loose)), [])) == 1


def told(*steps: tuple[int, int]) -> dict[int, ObservationUpdate]:
    """Give updates by number: each is of the try with the second number."""
    return {
        number: ObservationUpdate(
            number=number,
            id=f"dome-{made:06d}",
            request=f"r{made}",
            state=ObservationState.IN_PROGRESS,
            time=0.0,
        )
        for number, made in steps
    }


def test_an_update_that_never_came_is_missed() -> None:
    assert list(judge_numbers(told((1, 1), (2, 1), (3, 2)))) == []
    assert len(list(judge_numbers(told((1, 1), (3, 2))))) == 1


def test_of_a_long_night_without_a_hub_steps_may_be_left_out_but_no_try() -> None:
    steps = [(number, 1 + number // 100) for number in range(1, MOST_WAITING + 100, 7)]
    assert list(judge_numbers(told(*steps))) == []
    without = [(number, made) for number, made in steps if made != 3]
    assert len(list(judge_numbers(told(*without)))) == 1
