"""When hand-overs become batches, whatever they cost and however they come."""

from __future__ import annotations

from hypothesis import given, strategies as st

from talaia.gateway.samples.flush_pace import SOON_S, FlushPace

USUAL_S = 0.02
Costs = st.lists(st.floats(0, 0.5), max_size=60)


@given(Costs, st.floats(0.001, 60))
def test_what_is_watched_is_never_later_than_the_rest_nor_sooner_than_an_adapter_reads(
    costs: list[float], usual_s: float
) -> None:
    pace = FlushPace(usual_s)
    for cost_s in costs:
        pace.add_cost(cost_s)
        assert min(SOON_S, usual_s) <= pace.soon_s <= usual_s


@given(st.floats(0, 0.001))
def test_batches_that_are_made_soon_take_a_small_share_of_the_loop(cost_s: float) -> None:
    pace = FlushPace(USUAL_S)
    for _ in range(100):
        pace.add_cost(cost_s)
    assert cost_s <= 0.06 * pace.soon_s


@given(Costs, st.lists(st.tuples(st.floats(0, 0.1), st.booleans()), min_size=1, max_size=60))
def test_a_batch_of_what_is_watched_puts_off_nothing_else(
    costs: list[float], batches: list[tuple[float, bool]]
) -> None:
    pace, now_s, whole_s = FlushPace(USUAL_S), 0.0, 0.0
    for cost_s in costs:
        pace.add_cost(cost_s)
    pace.begin_batch(now_s, whole=True)
    for later_s, whole in batches:
        now_s += later_s
        pace.begin_batch(now_s, whole=whole)
        whole_s = now_s if whole else whole_s
        assert pace.late_s <= whole_s + 1.26 * USUAL_S
        assert now_s < pace.soon_ripe_s < pace.soon_late_s <= now_s + 1.26 * pace.soon_s
        assert pace.ripe_s < pace.late_s


@given(st.floats(0, 60))
def test_who_wants_a_sample_seldom_gets_batches_less_soon(wanted_s: float) -> None:
    pace = FlushPace(USUAL_S)
    pace.wanted_s = wanted_s
    assert abs(pace.soon_s - min(USUAL_S, max(SOON_S, wanted_s / 5))) < 1e-9


def test_one_batch_that_was_slow_by_chance_changes_little() -> None:
    pace = FlushPace(USUAL_S)
    pace.add_cost(0.001)
    assert pace.soon_s == SOON_S
    for _ in range(20):
        pace.add_cost(0.001)
    assert SOON_S < pace.soon_s < USUAL_S
