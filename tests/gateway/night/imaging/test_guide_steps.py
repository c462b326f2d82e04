"""A field is dithered between frames: by the guider that holds a star, else by the mount."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given, strategies as st
from night_observatory import EVENING, PureObservatory, example_site, place_of_date, request

from talaia.gateway.night.block_run import BlockParts
from talaia.gateway.night.imaging.guide_steps import dithered_place
from talaia.gateway.night.target_place import arcseconds_between
from talaia.model.observing.requests import Guiding
from talaia.model.observing.states import ObservationState

pytestmark = pytest.mark.pure


def observe(site: PureObservatory) -> list[tuple[float, float]]:
    """Let *m31* be observed; give where the telescope was sent (h, °)."""
    site.choice = lambda _question: "m31"
    site.arm()
    site.until(lambda: any(one.state is ObservationState.COMPLETED for one in site.changes))
    return [(args["ra"], args["dec"]) for args in site.args if "ra" in args]  # type: ignore[misc]


def test_without_a_guider_the_mount_dithers_between_frames_about_the_field() -> None:
    site = PureObservatory()
    group = request("m31", frames=5, dither=20.0)
    site.ask(group)
    sent = observe(site)
    # The field, and another place before each frame but the first.
    assert len(sent) == 5
    assert len(site.asked("camera/expose")) == 5
    place = example_site().place
    assert place is not None
    middle = place_of_date(group.requests[0].target, EVENING, place)
    assert middle is not None
    off = [arcseconds_between(where, middle) for where in sent]
    assert off[0] < 1.0
    assert all(1.0 < far <= 21.0 for far in off[1:])
    assert min(arcseconds_between(a, b) for a, b in pairwise(sent)) > 1.0


def test_a_guider_that_holds_a_star_dithers_and_the_mount_is_left_alone() -> None:
    site = PureObservatory(parts=BlockParts(guides=True))
    site.ask(request("m31", frames=4, dither=20.0))
    assert len(observe(site)) == 1
    assert len(site.asked("part/dither")) == 3


def test_with_a_guider_that_is_not_wanted_the_mount_dithers() -> None:
    site = PureObservatory(parts=BlockParts(guides=True))
    site.ask(request("m31", frames=3, dither=20.0, guiding=Guiding.OFF))
    assert len(observe(site)) == 3
    assert site.asked("part/dither") == []


@given(
    st.floats(0.0, 24.0, exclude_max=True),
    st.floats(-89.0, 89.0),
    st.floats(0.1, 600.0),
    st.integers(0, 10_000),
)
def test_no_place_is_farther_off_than_was_asked(
    ra: float, dec: float, dither: float, number: int
) -> None:
    far = arcseconds_between(dithered_place((ra, dec), dither, number), (ra, dec))
    # Right ascension is stretched by the declination of the place itself.
    assert far <= dither * 1.02 + 0.01
