"""Lease: one holder at a time, epochs that only rise."""

from itertools import count, pairwise

import pytest
from hypothesis import given, strategies as st

from talaia.clock import SECOND
from talaia.gateway.driving.lease import DeviceLease

pytestmark = pytest.mark.pure


def lease() -> DeviceLease:
    numbers = count(1)
    return DeviceLease(3 * SECOND, lambda: next(numbers))


def test_free_lease_is_granted() -> None:
    one = lease()
    assert one.take_lease("tab", "Ada", 0) == ""
    assert one.holder_at(0).session == "tab"


def test_second_asker_is_told_who_drives() -> None:
    one = lease()
    one.take_lease("tab", "Ada", 0)
    assert one.take_lease("other", "Ben", 0) == "Ada is driving"


def test_lease_that_is_not_renewed_ends_by_time_alone() -> None:
    one = lease()
    one.take_lease("tab", "Ada", 0)
    assert one.holder_at(3 * SECOND - 1) is not None
    assert one.holder_at(3 * SECOND) is None


def test_renewal_that_comes_too_late_does_not_bring_it_back() -> None:
    one = lease()
    one.take_lease("tab", "Ada", 0)
    assert one.renew_lease("tab", 3 * SECOND) != ""
    assert one.holder_at(3 * SECOND) is None


def test_renewal_keeps_the_epoch_and_a_second_take_raises_it() -> None:
    one = lease()
    one.take_lease("tab", "Ada", 0)
    one.renew_lease("tab", SECOND)
    assert one.holder_at(SECOND).epoch == 1
    one.take_lease("tab", "Ada", SECOND)
    assert one.holder_at(SECOND).epoch == 2


steps = st.tuples(
    st.sampled_from(["take", "renew", "free", "drop"]),
    st.sampled_from(["a", "b", "c"]),
    st.integers(0, 4 * SECOND),
)


@given(st.lists(steps, max_size=80))
def test_there_are_never_two_holders_and_epochs_strictly_rise(
    history: list[tuple[str, str, int]],
) -> None:
    one, now = lease(), 0
    epochs: list[int] = []
    for what, session, wait in history:
        now += wait
        before = one.holder_at(now)
        if what == "take":
            refused = one.take_lease(session, session, now)
            after = one.holder_at(now)
            assert bool(refused) == (before is not None and before.session != session)
            if refused:
                assert after == before
            else:
                epochs.append(after.epoch)
                assert after.session == session
        elif what == "renew":
            refused = one.renew_lease(session, now)
            assert bool(refused) == (before is None or before.session != session)
        elif what == "free":
            assert one.free_lease(session, now) == (
                before is not None and before.session == session
            )
        else:
            one.drop_lease()
            assert one.holder_at(now) is None
    assert all(later > earlier for earlier, later in pairwise(epochs))
