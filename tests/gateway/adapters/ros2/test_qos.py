"""Qualities of service: a subscription hears every publisher."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from talaia.gateway.adapters.ros2.qos import QosProfile, fits, quality_for

pytestmark = pytest.mark.pure

qualities = st.builds(QosProfile, st.booleans(), st.booleans())


@given(st.lists(qualities, min_size=1, max_size=5))
def test_subscription_hears_every_publisher_it_was_made_for(offers: list[QosProfile]) -> None:
    asked = quality_for(offers)
    assert fits(asked, offers)
    if all(each.reliable for each in offers):
        assert asked.reliable
    if not all(each.latched for each in offers):
        assert not asked.latched


def test_subscription_is_changed_only_for_a_publisher_it_would_not_hear() -> None:
    assert not fits(QosProfile(reliable=True, latched=False), [QosProfile(False, False)])  # noqa: FBT003
    assert fits(QosProfile(reliable=False, latched=False), [QosProfile(True, True)])  # noqa: FBT003
