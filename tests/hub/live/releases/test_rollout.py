"""Which gateways are offered a release, and when a rollout goes on, stops and ends."""

from hypothesis import given, strategies as st

from talaia.hub.live.releases.rollout import (
    Rollout,
    SiteProgress,
    SiteStage,
    advance_rollout,
    due_sites,
)
from talaia.wire.frames import ReleaseState

OLD, NEW = "1.0.0", "1.1.0"
INSTALLED = ReleaseState(current=OLD, phase="waiting", candidate=NEW, waits="it is driven")
KEPT = ReleaseState(current=NEW)
LEFT = ReleaseState(current=OLD, failed={NEW: "no link to the hub within 180 s"})


def rollout(*sites, first=1, at_once=2):
    return Rollout(
        id="w1", version=NEW, who="ada", began_us=0, first=first, at_once=at_once,
        sites={name: SiteProgress() for name in sites},
    )  # fmt: skip


def stages(now):
    return {name: site.stage.value for name, site in now.sites.items()}


def offer_due(now, reports):
    return advance_rollout(now, frozenset(due_sites(now)), reports)


def test_the_next_stage_begins_when_all_of_the_one_before_run_the_release() -> None:
    now = rollout("a", "b", "c", "d")
    assert due_sites(now) == ["a"]
    now = offer_due(now, {})
    assert stages(now) == {"a": "offered", "b": "queued", "c": "queued", "d": "queued"}
    now = advance_rollout(now, frozenset(), {"a": INSTALLED})
    assert now.sites["a"].stage is SiteStage.BEGUN
    # Waits for rest, as long as that takes.
    assert due_sites(now) == []
    now = advance_rollout(now, frozenset(), {"a": KEPT})
    assert due_sites(now) == ["b", "c"]
    now = offer_due(now, {"b": KEPT})
    assert due_sites(now) == ["c"]
    now = advance_rollout(now, frozenset(), {"c": KEPT})
    now = offer_due(now, {"d": KEPT})
    assert set(stages(now).values()) == {"done"}
    assert not now.runs


def test_the_first_that_leaves_the_release_stops_it_for_all_others() -> None:
    now = offer_due(rollout("a", "b", first=1), {})
    now = advance_rollout(now, frozenset(), {"a": INSTALLED})
    now = advance_rollout(now, frozenset(), {"a": LEFT})
    assert now.stopped == "a: no link to the hub within 180 s"
    assert due_sites(now) == []
    assert not now.runs


def test_what_was_left_before_the_offer_says_nothing_of_this_time() -> None:
    now = offer_due(rollout("a"), {"a": LEFT})
    now = advance_rollout(now, frozenset(), {"a": LEFT})
    assert stages(now) == {"a": "offered"}
    # What is answered to an offer of before neither.
    other = ReleaseState(current=OLD, answered="w0", failed=LEFT.failed)
    assert advance_rollout(now, frozenset(), {"a": other}) is now
    refused = ReleaseState(current=OLD, answered="w1", failed={NEW: "signed by nobody"})
    now = advance_rollout(now, frozenset(), {"a": refused})
    assert now.stopped == "a: signed by nobody"


def test_a_release_that_is_fetched_is_not_begun_and_may_be_offered_again() -> None:
    now = offer_due(rollout("a"), {})
    fetching = ReleaseState(current=OLD, phase="fetching", candidate=NEW, fetched=7)
    now = advance_rollout(now, frozenset(), {"a": fetching})
    assert due_sites(now) == ["a"]


REPORTS = st.sampled_from([
    None, KEPT, INSTALLED, LEFT, ReleaseState(current=OLD),
    ReleaseState(current=OLD, answered="w1", failed=LEFT.failed),
])  # fmt: skip


@given(
    count=st.integers(1, 8),
    first=st.integers(1, 4),
    at_once=st.integers(1, 4),
    rounds=st.lists(st.dictionaries(st.integers(0, 7), REPORTS), max_size=20),
)
def test_nobody_is_offered_a_release_before_those_of_earlier_stages_have_it(
    count: int, first: int, at_once: int, rounds: list[dict[int, ReleaseState | None]]
) -> None:
    names = [f"s{number}" for number in range(count)]
    now = rollout(*names, first=first, at_once=at_once)
    stage_of = {name: 0 if at < first else 1 + (at - first) // at_once
                for at, name in enumerate(names)}  # fmt: skip
    for reports in rounds:
        due = due_sites(now)
        assert not (due and now.stopped)
        for name in due:
            before = [other for other in names if stage_of[other] < stage_of[name]]
            assert all(now.sites[other].stage is SiteStage.DONE for other in before)
        heard = {f"s{at}": said for at, said in reports.items() if said and at < count}
        after = advance_rollout(now, frozenset(due), heard)
        for name in names:
            # What has come to an end stays so.
            if now.sites[name].stage in (SiteStage.DONE, SiteStage.FAILED):
                assert after.sites[name] == now.sites[name]
        assert bool(after.stopped) == any(
            site.stage is SiteStage.FAILED for site in after.sites.values()
        )
        now = after
