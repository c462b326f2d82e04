"""How far a gateway's clock is from the hub's."""

import pytest
from hypothesis import given, strategies as st

from talaia.hub.live.gateways.clock_offset import ClockOffset

pytestmark = pytest.mark.pure


@given(st.lists(st.tuples(st.integers(0, 500_000), st.integers(0, 500_000)), min_size=1))
def test_offset_errs_by_no_more_than_half_of_the_quickest_loop(ways) -> None:
    true_offset, now = 7_000_000, 0
    offset = ClockOffset()
    for there, back in ways[-60:]:
        now += 1_000_000
        offset.add_beat(now, now + there + back, now + there + true_offset)
    best = min(there + back for there, back in ways[-60:])
    assert abs(offset.to_ours(now + true_offset) - now) <= best / 2 + 1


def test_without_a_beat_nothing_is_known_of_the_other_clock() -> None:
    assert ClockOffset().to_ours(1) is None
