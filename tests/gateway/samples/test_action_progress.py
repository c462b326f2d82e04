"""The progress of actions: what counts up to an end, and what counts down to none."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, strategies as st

from talaia.gateway.samples.action_progress import ActionProgress
from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.load import load_site

pytestmark = pytest.mark.pure


def test_what_counts_up_is_done_at_its_end() -> None:
    progress = ActionProgress(100)
    assert [progress.share_of(value) for value in (0, 25, 100, 150, -5)] == [0, 0.25, 1, 1, 0]


def test_a_distance_that_is_left_counts_down_from_the_greatest_that_was_said() -> None:
    progress = ActionProgress(0)
    # Nav2 says 0 until it has found a path, and the way may turn out to be longer.
    assert [progress.share_of(value) for value in (0, 8, 4, 16, 4, 0)] == [0, 0, 0.5, 0, 0.75, 1]


@given(st.sampled_from([0.0, 1.0, 250.0]), st.lists(st.floats()))
def test_whatever_comes_the_share_is_one(end: float, values: list[float]) -> None:
    progress = ActionProgress(end)
    shares = [progress.share_of(value) for value in values]
    assert all(0 <= share <= 1 for share in shares)
    assert not any(math.isnan(share) for share in shares)


def test_a_description_may_have_a_progress_that_counts_down() -> None:
    found = check_site(
        load_site(
            """
talaia: 1
site: s
name: S
ros2: {}
devices:
  base:
    name: Base
    commands:
      goto: {name: Go to, kind: action, target: /go, type: nav2_msgs/action/NavigateToPose,
             progress: distance_remaining, progress_end: 0}
"""
        )
    )
    assert found == []
