"""A slope is told from noise, and judged with its uncertainty."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from many_examples import examples

from .report import CACHE, FIGURES, Sample, passed, table
from .slopes import Point, Verdict, by_minute, judge, slope_of

HOURS = np.arange(120) / 60


def line(slope: float, noise: float = 0.0, life: int = 0) -> list[Point]:
    random = np.random.default_rng(3)
    values = 100 + slope * HOURS + random.normal(0, noise, HOURS.size)
    return [Point(*each, life) for each in zip(HOURS.tolist(), values.tolist(), strict=True)]


def test_a_leak_in_noise_is_broken_and_noise_alone_holds() -> None:
    leak, calm = slope_of(line(12.0, noise=3.0)), slope_of(line(0.0, noise=3.0))
    assert leak is not None
    assert leak.low < 12.0 < leak.high
    assert judge(leak, 4.0) is Verdict.BROKEN
    assert judge(calm, 4.0) is Verdict.HOLDS


def test_what_is_as_near_the_limit_as_its_noise_is_unclear() -> None:
    assert judge(slope_of(line(4.0, noise=3.0)), 4.0) is Verdict.UNCLEAR
    assert judge(None, 4.0) is Verdict.UNCLEAR


def test_a_process_that_begins_anew_hides_no_leak() -> None:
    # Each life grows by 10 an hour and begins at 100 again; over all of it nothing grows.
    lives = [
        Point(life / 2 + minute / 60, 100 + 10 * minute / 60, life)
        for life in range(4)
        for minute in range(30)
    ]
    found = slope_of(lives)
    assert found is not None
    assert found.each_hour == pytest.approx(10.0)
    assert judge(found, 4.0) is Verdict.BROKEN


def test_a_saw_tooth_and_a_single_spike_do_not_grow() -> None:
    saw = [Point(at, float(minute % 7)) for minute, at in enumerate(HOURS.tolist())]
    spike = [*line(0.0)[:60], Point(1.0, 1e6), *line(0.0)[61:]]
    assert judge(slope_of(saw), 1.0) is Verdict.HOLDS
    assert judge(slope_of(spike), 1.0) is Verdict.HOLDS


def test_a_life_that_is_too_short_says_nothing() -> None:
    assert slope_of([Point(at / 60, at, life) for life in range(9) for at in range(3)]) is None


@settings(max_examples=examples(25, many=1000), deadline=None)
@given(st.floats(-100, 100), st.floats(-1e4, 1e4), st.integers(4, 60))
def test_a_straight_line_has_its_own_slope(slope: float, start: float, count: int) -> None:
    points = [Point(at / 60, start + slope * at / 60) for at in range(count)]
    found = slope_of(points)
    assert found is not None
    for each in found[:3]:
        assert each == pytest.approx(slope, rel=1e-6, abs=1e-6)


def test_each_minute_of_each_life_gives_its_median() -> None:
    points = [Point(second / 3600, float(second), 0) for second in range(0, 120, 10)]
    points += [Point(1.999 / 60, 7.0, 1)]
    assert [(each.value, each.life) for each in by_minute(points)] == [
        (25.0, 0), (85.0, 0), (7.0, 1)
    ]  # fmt: skip


def run_of(hours: float, slope: float, *, noise: float = 0.0, errors: int = 0) -> list[Sample]:
    random = np.random.default_rng(4)
    return [
        Sample(
            s=float(s),
            figures={
                name: 100 + slope * s / 3600 + float(random.normal(0, noise)) for name in FIGURES
            },
            rows={"sessions": s // 60, "roles": 3},
            lives={"hub": 0, "gateway": int(s > 3000)},
            ages={"hub": float(s), "gateway": s - 3000 if s > 3000 else float(s)},
            done={"drive": s // 60},
            errors=["the hub ended"] * errors,
            cpu_s=s / 5,
        )
        for s in range(0, int(hours * 3600) + 1, 20)
    ]


def test_a_table_has_each_figure_beside_its_limit() -> None:
    said = table(run_of(2.0, 0.0))
    for name, limit in FIGURES.items():
        (row,) = [each for each in said.splitlines() if each.startswith(f"| {name} |")]
        assert f"| {limit:+,.0f} | holds |" in row
    assert "| rows of sessions | 30.0 | 120.0 | 120.0 | +60.00 (" in said
    assert "roles" not in said
    assert "20% of one core" in said


def test_what_a_process_takes_while_it_warms_up_is_left_out() -> None:
    samples = run_of(2.0, 0.0)
    for each in samples:
        if each["ages"]["gateway"] < 1800:
            each["figures"]["gateway: memory (RSS), MiB"] = each["ages"]["gateway"]
    assert passed(samples)


def test_a_run_passes_only_when_nothing_is_broken_and_nobody_saw_an_error() -> None:
    assert passed(run_of(2.0, 0.0))
    assert not passed(run_of(2.0, 100.0))
    assert not passed(run_of(2.0, 0.0, errors=1))
    # Caches fill for a while; a leak of a hundred is seen all the same.
    assert not passed(run_of(0.3, 100.0))
    # A run of twenty minutes may leave something open; one of two hours may not.
    assert passed(run_of(0.3, 0.9, noise=1.0))
    assert not passed(run_of(2.0, 0.9, noise=1.0))


def test_a_journal_that_goes_up_and_down_by_hours_is_judged_by_its_most() -> None:
    samples = run_of(2.0, 0.0)
    for each in samples:
        each["rows"] = {"history_hot": round(each["s"] * 10)}
    assert passed(samples)
    samples[-1]["rows"] = {"history_hot": 120_001}
    assert not passed(samples)


def test_a_cache_that_fills_is_no_leak_until_it_is_over_its_bound() -> None:
    samples = run_of(2.0, 0.0)
    for each in samples:
        each["figures"][CACHE] = each["s"] / 600
        each["figures"]["hub: memory (RSS), MiB"] += each["s"] / 600
    assert passed(samples)
    assert f"| {CACHE} | 3.0 | 12.0 | 12.0 |" in table(samples)
    # What grows beside it is seen all the same.
    for each in samples:
        each["figures"]["hub: memory (RSS), MiB"] += each["s"] / 600
    assert not passed(samples)
    full = run_of(2.0, 0.0)
    full[-1]["figures"][CACHE] = 17.0
    assert not passed(full)
