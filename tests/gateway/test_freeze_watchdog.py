"""A gateway that was itself late does not take that for a silent station; real silence counts."""

from __future__ import annotations

from hypothesis import given, strategies as st

from talaia.clock import SECOND
from talaia.gateway.freeze_watchdog import FreezeCredit, FreezeDetector

TICK = SECOND // 10


def look(credit: FreezeCredit, from_ns: int, to_ns: int) -> int:
    """Let it run, ten looks a second; give when."""
    for now in range(from_ns, to_ns + 1, TICK):
        credit.mark_running(now)
    return to_ns


def test_what_was_slept_through_is_no_age_until_it_has_settled() -> None:
    credit = FreezeCredit(0)
    now = look(credit, 0, 10 * SECOND)
    # It stands still for a minute; what was heard at 9 s is one second old as it ran.
    now += 60 * SECOND
    assert credit.age_ns(9 * SECOND, now) == SECOND
    look(credit, now, now + SECOND)
    assert credit.age_ns(9 * SECOND, now + SECOND) == 2 * SECOND
    look(credit, now + SECOND, now + 3 * SECOND)
    assert credit.age_ns(9 * SECOND, now + 3 * SECOND) == 64 * SECOND
    # What came after waking is as old as it is.
    assert credit.age_ns(now + SECOND, now + 3 * SECOND) == 2 * SECOND


def test_one_that_runs_well_credits_nothing() -> None:
    credit = FreezeCredit(0)
    now = look(credit, 0, 30 * SECOND)
    assert credit.age_ns(SECOND, now) == 29 * SECOND


@given(st.lists(st.tuples(st.integers(1, 40), st.integers(6, 100)), min_size=1, max_size=40))
def test_silence_counts_after_two_seconds_of_running_however_often_it_stands_still(
    runs: list[tuple[int, int]],
) -> None:
    credit, now, ran = FreezeCredit(0), 0, 0
    slept: list[int] = []
    for ticks, still in runs:
        for _ in range(ticks):
            now += TICK
            ran += TICK if slept else 0
            age = credit.age_ns(0, now)
            assert age in (now, now - sum(slept[-FreezeCredit.KEPT :]))
            if len(slept) <= FreezeCredit.KEPT and ran > FreezeCredit.SETTLE_NS:
                assert age == now
        now += still * TICK
        slept.append(still * TICK)
        credit.mark_running(now)


def test_silence_counts_although_every_look_comes_late() -> None:
    credit = FreezeCredit(0)
    for now in range(0, 60 * SECOND, SECOND):
        age = credit.age_ns(0, now)
        assert age >= now - FreezeCredit.KEPT * SECOND
    assert age > 50 * SECOND


def test_process_that_stood_still_knows_from_when_to_when() -> None:
    stalls = FreezeDetector(0)
    assert stalls.detect_stall(1_000 * SECOND, SECOND) is None
    # The wall clock may have been set meanwhile: how long it was is the other clock's to say.
    assert stalls.detect_stall(5_000 * SECOND, 31 * SECOND) == (4_970_000_000, 5_000_000_000)
    assert stalls.detect_stall(5_001 * SECOND, 32 * SECOND) is None
