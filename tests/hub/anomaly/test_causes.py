"""Anomalies of one cause, and the last time it was so."""

from __future__ import annotations

import itertools

from hypothesis import given, settings, strategies as st

from talaia.hub.anomaly.causes import (
    ONE_CAUSE_US,
    Beginning,
    Episode,
    gather_episodes,
    most_similar,
)

SECOND = 1_000_000


def test_what_begins_within_a_minute_of_the_one_before_is_one_episode():
    found = gather_episodes(
        [
            Beginning(200 * SECOND, "base", "Speed"),
            Beginning(10 * SECOND, "base", "Speed"),
            Beginning(60 * SECOND, "power", "Voltage"),
        ]
    )
    assert [(one.began_us, len(one.names)) for one in found] == [
        (10 * SECOND, 2),
        (200 * SECOND, 1),
    ]


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 10**10), st.sampled_from("abc")), max_size=30))
def test_every_beginning_is_in_one_episode_and_episodes_lie_apart(rows):
    beginnings = [Beginning(time_us, "device", name) for time_us, name in rows]
    episodes = gather_episodes(beginnings)
    for one in beginnings:
        assert sum(other.began_us <= one.time_us <= other.last_us for other in episodes) == 1
    for one, after in itertools.pairwise(episodes):
        assert after.began_us - one.last_us > ONE_CAUSE_US


def episode(at: int, *names: str) -> Episode:
    return Episode(at, at, frozenset(("base", name) for name in names))


def test_the_most_similar_episode_has_most_in_common_and_of_several_it_is_the_last():
    before = [episode(1, "a", "b"), episode(2, "a", "b"), episode(3, "a", "c", "d")]
    found = most_similar(episode(9, "a", "b", "c").names, before)
    assert found is not None
    assert (found[0].began_us, round(found[1], 2)) == (2, 0.67)


def test_an_episode_that_has_little_in_common_is_not_similar():
    assert most_similar(episode(9, "a", "b", "c").names, [episode(1, "a", "x", "y")]) is None
