"""When the room is used up, from rates, retention, limit and disk alone."""

import pytest
from hypothesis import given, strategies as st

from talaia.hub.history.forecast import (
    DAY_US,
    WEEK_US,
    Growth,
    StorageRoom,
    Warn,
    forecast_storage,
    growth_of,
)

NOW = 1_790_000_000_000_000
GB = 10**9


def a_day(count, keep_days=0.0, days_old=30.0):
    """Grow by so many bytes a day."""
    return Growth(count / DAY_US, NOW - round(days_old * DAY_US), round(keep_days * DAY_US))


def days(us):
    return None if us is None else (us - NOW) / DAY_US


def test_without_retention_and_limit_the_disk_is_full_when_it_is() -> None:
    said = forecast_storage(
        StorageRoom(GB, 0, 10 * GB, 100 * GB, share=1.25), [a_day(GB / 5)] * 2, NOW
    )
    assert days(said.full_us) == pytest.approx(20.0)
    assert (said.by_limit, said.kept_us, said.warn) == (False, None, Warn.NOTHING)
    assert said.day_bytes == pytest.approx(GB / 2)
    assert said.oldest_us == NOW - 30 * DAY_US


def test_what_is_kept_for_some_days_stops_growing_then() -> None:
    brief, long = a_day(GB, keep_days=5, days_old=2), a_day(GB, days_old=2)
    # Both for three days, then one alone.
    said = forecast_storage(StorageRoom(0, 0, 10 * GB, 100 * GB), [brief, long], NOW)
    assert days(said.full_us) == pytest.approx(7.0)
    assert days(said.oldest_us) == pytest.approx(-2.0)
    alone = forecast_storage(StorageRoom(0, 0, 10 * GB, 100 * GB), [brief], NOW)
    assert (alone.full_us, alone.oldest_us) == (None, None)
    full = forecast_storage(StorageRoom(0, 0, 2 * GB, 100 * GB), [brief], NOW)
    assert days(full.full_us) == pytest.approx(2.0)


def test_at_the_limit_the_oldest_go_and_it_says_how_much_is_kept() -> None:
    said = forecast_storage(StorageRoom(4 * GB, 10 * GB, 500 * GB, 1_000 * GB), [a_day(GB)], NOW)
    assert said.by_limit
    assert days(said.full_us) == pytest.approx(6.0)
    assert said.kept_us == pytest.approx(10 * DAY_US)
    assert said.warn is Warn.LIMIT
    reached = forecast_storage(
        StorageRoom(10 * GB, 10 * GB, 500 * GB, 1_000 * GB), [a_day(GB)], NOW
    )
    assert days(reached.full_us) == 0.0
    assert reached.warn is Warn.NOTHING
    # Retention alone keeps it below the limit.
    below = forecast_storage(StorageRoom(GB, 10 * GB, 500 * GB), [a_day(GB, keep_days=3)], NOW)
    assert (below.full_us, below.kept_us) == (None, None)


def test_a_disk_that_is_full_before_the_limit_is_what_counts() -> None:
    said = forecast_storage(StorageRoom(GB, 100 * GB, 5 * GB, 50 * GB), [a_day(GB)], NOW)
    assert (said.by_limit, days(said.full_us), said.warn) == (False, pytest.approx(5.0), Warn.SOON)


@pytest.mark.parametrize(
    ("free", "disk", "warn"),
    [
        (0.7 * GB, 16 * GB, Warn.FULL),
        (0.9 * GB, 16 * GB, Warn.NOTHING),
        (3 * GB, 4_000 * GB, Warn.NOTHING),
        (1.9 * GB, 4_000 * GB, Warn.FULL),
    ],
)
def test_a_disk_is_nearly_full_by_share_and_by_size(free, disk, warn) -> None:
    assert forecast_storage(StorageRoom(GB, 0, round(free), disk), [], NOW).warn is warn


def test_of_a_server_s_disk_nothing_is_said() -> None:
    said = forecast_storage(StorageRoom(GB, 0, None), [a_day(GB)], NOW)
    assert (said.full_us, said.warn) == (None, Warn.NOTHING)


def test_a_rate_is_of_a_week_or_of_as_long_as_there_is_anything() -> None:
    assert growth_of(7_000, NOW - 90 * DAY_US, 0, NOW).rate == 7_000 / WEEK_US
    assert growth_of(7_000, NOW - 2 * DAY_US, 0, NOW).rate == 7_000 / (2 * DAY_US)
    # A clock that is ahead, and a store of a minute.
    assert growth_of(7_000, NOW + DAY_US, 0, NOW).rate == 7_000 / (DAY_US / 24)


growths = st.builds(
    a_day,
    st.floats(0, 1e10),
    st.floats(0.01, 400) | st.just(0.0),
    st.floats(0, 400),
)


@given(st.lists(growths, max_size=8), st.integers(1, 10**12))
def test_at_the_foretold_moment_what_has_grown_fits_exactly(growing, free) -> None:
    said = forecast_storage(StorageRoom(0, 0, free), growing, NOW)

    def grown(us):
        return sum(
            each.rate
            * (min(us, max(0, each.first_us + each.keep_us - NOW)) if each.keep_us else us)
            for each in growing
        )

    if said.full_us is None:
        assert grown(36_000 * DAY_US) < free * (1 + 1e-6)
    else:
        assert grown(said.full_us - NOW) == pytest.approx(free, rel=1e-6, abs=1.0)
