"""Rights that include one another, and the one to raw topics that stands beside them."""

from __future__ import annotations

import pytest

from talaia.hub.auth.permissions import Grants, Permission, Right

PLACES = [("*", "*"), ("agv", "*"), ("agv", "base")]


def test_the_right_to_tap_comes_with_admin_and_with_nothing_else() -> None:
    for held in Right:
        grants = Grants(frozenset({Permission(held)}))
        assert grants.has_right(Right.TAP, "agv") == (held in {Right.TAP, Right.ADMIN})
    tap = Grants(frozenset({Permission(Right.TAP)}))
    assert not any(tap.has_right(right, "agv") for right in Right if right is not Right.TAP)
    assert tap.rights_on("agv", "base") == []


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("ours", Right)
@pytest.mark.parametrize("theirs", Right)
def test_what_is_left_of_two_rights_is_never_more_than_either(ours, theirs, place) -> None:
    held = Grants(frozenset({Permission(ours, *place)}))
    given = frozenset({Permission(theirs)})
    left = held.limited_to(given)
    for right in Right:
        expected = held.has_right(right, "agv", "base") and Grants(given).has_right(
            right, "agv", "base"
        )
        assert left.has_right(right, "agv", "base") == expected
