"""How many sightings of a site are taken, and what is said of them."""

from __future__ import annotations

import pytest
from msgspec import structs

from talaia.hub.live.detection.sighting_limits import SiteSightings, merge_sightings, said_of
from talaia.hub.store.sites.sightings import Sighted
from talaia.model.yaml_text.load import load_site

from ...conftest import DESCRIPTION

# 14 November 2023, 22:13:20 UTC.
BEGAN = 1_700_000_000_000_000
MINUTE, DAY = 60_000_000, 86_400_000_000


def sighted(**said: object) -> Sighted:
    told = Sighted("agv", "camera/front", "person", BEGAN, BEGAN + 3 * MINUTE, 1, 0.8, BEGAN, "b")
    return told._replace(**said)


def test_a_thousand_are_taken_at_once_and_then_five_a_second() -> None:
    site = SiteSightings(100.0)
    assert sum(site.spend_token(100.0) for _ in range(2000)) == 1000
    assert sum(site.spend_token(102.0) for _ in range(2000)) == 10
    assert sum(site.spend_token(10_000.0) for _ in range(2000)) == 1000


def test_no_more_are_in_sight_and_waiting_than_a_person_could_follow() -> None:
    site = SiteSightings(0.0)
    assert site.takes_more(499, 0.0)
    assert not site.takes_more(500, 0.0)


def test_what_is_left_out_is_told_once_and_counted_until_a_minute_is_calm() -> None:
    site = SiteSightings(0.0)
    assert [site.leaves_out(at) for at in (1.0, 2.0, 3.0)] == [True, False, False]
    assert site.calm_again(63.0) == 0
    assert site.calm_again(63.1) == 3
    assert site.calm_again(200.0) == 0
    assert site.leaves_out(201.0)


def test_the_newer_word_counts_and_a_picture_stays_until_there_is_another() -> None:
    first = sighted(picture=b"one", many=1)
    again, other = sighted(many=3), sighted(label="dog")
    both = merge_sightings({first.key: first}, {again.key: again, other.key: other})
    assert both == {first.key: sighted(picture=b"one", many=3), other.key: other}
    newer = sighted(picture=b"two")
    assert merge_sightings({first.key: first}, {first.key: newer}) == {first.key: newer}


@pytest.mark.parametrize(
    ("ended_us", "many", "said"),
    [
        (BEGAN, 1, "22:13"),
        (BEGAN + 3 * MINUTE, 1, "22:13–22:16"),
        (BEGAN + 3 * MINUTE, 2, "22:13–22:16 (at most 2)"),
        (BEGAN + DAY, 1, "2023-11-14 22:13–2023-11-15 22:13"),
    ],
)
def test_the_logbook_says_what_was_seen_where_and_when(ended_us: int, many: int, said: str) -> None:
    seen = sighted(ended_us=ended_us, many=many)
    assert said_of(seen, None) == f"person seen at camera/front {said}"


def test_the_logbook_has_the_cameras_name_and_the_sites_time() -> None:
    site = structs.replace(load_site(DESCRIPTION), zone="Europe/Madrid")
    name = site.devices["camera"].streams["front"].name
    assert said_of(sighted(), site) == f"person seen at {name} 23:13–23:16"
