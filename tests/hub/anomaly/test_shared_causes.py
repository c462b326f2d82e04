"""Which anomalies are of one cause, and what each signal has of it."""

from __future__ import annotations

import itertools

import msgspec
import pytest
from hypothesis import given, settings, strategies as st

from talaia.hub.anomaly.causes import ONE_CAUSE_US
from talaia.hub.anomaly.shared_causes import (
    AGAIN_US,
    GROWS_US,
    LONGEST_US,
    CauseMember,
    SharedCauses,
)

SECOND = 1_000_000
NOW = 1_795_000_000 * SECOND


def member(address: str, began_us: int = NOW, **more: object) -> CauseMember:
    return CauseMember(address=address, detector="limits", began_us=began_us, **more)


def causes() -> SharedCauses:
    return SharedCauses(open={})


def test_what_begins_while_an_episode_of_its_part_is_open_is_of_it_and_another_part_is_not():
    site = causes()
    first, begins = site.begin_member("base", member("base/speed"), NOW)
    later, joins = site.begin_member("base", member("base/turn"), NOW + 1800 * SECOND)
    other, apart = site.begin_member("power", member("power/voltage"), NOW + SECOND)
    assert (begins, joins, apart) == (True, False, True)
    assert first is later
    assert first is not other


def test_it_is_over_when_all_are_normal_and_a_minute_has_passed_since_the_newest_began():
    site = causes()
    site.begin_member("base", member("base/speed"), NOW)
    site.begin_member("base", member("base/turn"), NOW + 30 * SECOND)
    site.end_member("base", "base/speed", "limits")
    assert site.close_over(NOW + 300 * SECOND) == []
    site.end_member("base", "base/turn", "limits")
    assert site.close_over(NOW + 30 * SECOND + ONE_CAUSE_US) == []
    ((part, cause),) = site.close_over(NOW + 31 * SECOND + ONE_CAUSE_US)
    assert (part, len(cause.members), site.open) == ("base", 2, {})
    _, begins = site.begin_member("base", member("base/speed"), NOW + 400 * SECOND)
    assert begins


def test_what_begins_an_hour_later_is_another_though_the_first_goes_on_and_is_not_counted_twice():
    site = causes()
    site.begin_member("base", member("base/speed"), NOW)
    cause, begins = site.begin_member("base", member("base/turn"), NOW + GROWS_US + 1)
    assert begins
    assert [(one.address, one.carried, one.times) for one in cause.members] == [
        ("base/speed", True, 0),
        ("base/turn", False, 1),
    ]
    assert cause.first.address == "base/turn"
    # The older one keeps it open.
    site.end_member("base", "base/turn", "limits")
    assert cause.on


def test_what_never_ends_holds_an_episode_for_a_day_after_the_newest_began():
    site = causes()
    site.begin_member("base", member("base/speed"), NOW)
    assert site.close_over(NOW + LONGEST_US) == []
    assert len(site.close_over(NOW + LONGEST_US + 1)) == 1


def test_a_signal_has_what_the_detector_gives_it_that_says_most_of_it():
    site = causes()
    shares = (("base/speed", 0.75), ("base/turn", 0.25))
    site.begin_member("base", member("/body", excess=0.8, shares=shares), NOW)
    cause, _ = site.begin_member("base", member("base/turn", excess=0.4), NOW)
    assert cause.signal_parts() == [
        ("base/speed", pytest.approx(0.6), True),
        ("base/turn", pytest.approx(0.4), True),
    ]
    site.end_member("base", "/body", "limits")
    assert [one.on for one in cause.signal_parts()] == [False, True]


def test_after_a_start_what_is_found_again_is_the_same_and_what_is_not_has_ended():
    site = causes()
    for address in ("base/speed", "base/turn"):
        site.begin_member("base", member(address), NOW)
    again = msgspec.msgpack.decode(msgspec.msgpack.encode(site), type=SharedCauses)
    again.mark_unsure(NOW + 60 * SECOND)
    found = member("base/turn", NOW + 80 * SECOND)
    cause, begins = again.begin_member("base", found, NOW + 80 * SECOND)
    assert not begins
    assert again.close_over(NOW + AGAIN_US) == []
    assert again.end_unsure()
    assert [(one.address, one.on, one.times) for one in cause.members] == [
        ("base/speed", False, 1),
        ("base/turn", True, 1),
    ]
    assert not again.end_unsure()


def test_parts_that_a_new_description_joins_are_one_episode_and_what_is_gone_is_none():
    site = causes()
    site.begin_member("base", member("base/speed"), NOW)
    site.begin_member("power", member("power/voltage"), NOW)
    site.begin_member("gone", member("gone/speed"), NOW)
    parts = {"base/speed": "base", "power/voltage": "base"}
    site.keep_parts(parts, ["base"])
    assert {one.address for one in site.open["base"].members} == {"base/speed", "power/voltage"}
    assert list(site.open) == ["base"]


# Which detector, whether its anomaly begins or ends, and how long after the one before.
TURNS = st.lists(
    st.tuples(
        st.sampled_from(["base/speed", "base/turn", "power/voltage", "power/current"]),
        st.integers(0, 2 * 3600),
    ),
    max_size=60,
)


@settings(max_examples=100, deadline=None)
@given(TURNS)
def test_each_anomaly_is_in_exactly_one_episode_and_memory_is_bounded(turns):
    site, on, now, begun = causes(), set(), NOW, 0
    seen = {}
    for address, after in turns:
        now += after * SECOND
        for _, cause in site.close_over(now):
            # What goes on for a day without anything new holds an episode no more.
            on -= {one.address for one in cause.members if one.on}
        part = address.partition("/")[0]
        if address in on:
            site.end_member(part, address, "limits")
            on.remove(address)
        else:
            cause, _ = site.begin_member(part, member(address, now), now)
            seen[id(cause)] = cause
            on.add(address)
            begun += 1
        assert all(len(cause.members) <= 2 for cause in site.open.values())
        going = [
            (part, one.address)
            for part, cause in site.open.items()
            for one in cause.members
            if one.on
        ]
        assert sorted(going) == sorted((one.partition("/")[0], one) for one in on)
    assert sum(one.times for cause in seen.values() for one in cause.members) == begun


@settings(max_examples=50, deadline=None)
@given(st.permutations(["base/a", "base/b", "base/c", "power/d"]), st.data())
def test_the_order_in_which_they_are_told_within_the_window_does_not_matter(order, data):
    def parts_of(addresses):
        site = causes()
        for at, address in enumerate(addresses):
            place = address.partition("/")[0]
            news = member(address, excess=excess[address])
            site.begin_member(place, news, NOW + at * SECOND)
        return {place: cause.signal_parts() for place, cause in site.open.items()}

    excess = {address: data.draw(st.floats(0, 1)) for address in sorted(order)}
    found, usual = parts_of(order), parts_of(sorted(order))
    assert found.keys() == usual.keys()
    for place, parts in usual.items():
        assert [one.address for one in found[place]] == [one.address for one in parts]
        assert sum(one.share for one in parts) == pytest.approx(1.0)
    for one, after in itertools.pairwise(found["base"]):
        assert one.share >= after.share
