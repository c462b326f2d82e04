"""A frame counts only where what it was to show was followed: a star, the sky, or neither."""

from __future__ import annotations

from itertools import pairwise

import pytest
from msgspec.structs import replace
from night_observatory import EVENING, PureObservatory, example_site, request

from talaia.gateway.night.block_run import BlockParts
from talaia.gateway.night.frames.frame_watch import LOST_S
from talaia.gateway.night.target_place import hour_angle_of
from talaia.model.observing.requests import Guiding
from talaia.model.observing.states import ObservationState
from talaia.model.observing.targets import FixedTarget

pytestmark = pytest.mark.pure
S = ObservationState


class Guider:
    """Holds a star, or says that it is lost."""

    def __init__(self) -> None:
        """Hold it."""
        self.lost = ""

    def parts(self) -> BlockParts:
        return BlockParts(guides=True, guide_lost=lambda: self.lost)


def begin(site: PureObservatory, name: str, **more: object) -> None:
    site.ask(request(name, **more))
    site.choice = lambda _question: name
    site.arm()


def ended(site: PureObservatory) -> bool:
    return any(one.state in {S.COMPLETED, S.FAILED} for one in site.changes)


def test_a_guide_star_that_is_lost_while_it_must_be_held_ends_the_frame_which_is_taken_again() -> (
    None
):
    guider = Guider()
    site = PureObservatory(parts=guider.parts())
    begin(site, "m31", guiding=Guiding.ON)
    site.until(lambda: len(site.frames) == 1 and len(site.asked("camera/expose")) == 2)
    site.pass_time(20)
    guider.lost = "the guide star is lost"
    site.pass_time(LOST_S + 3)
    guider.lost = ""
    assert len(site.asked("camera/abort")) == 1
    assert site.changes[-1].frames_done == (1,)
    site.until(lambda: ended(site))
    assert site.changes[-1].state is S.COMPLETED
    # Three were read out; the one that was lost is not among them.
    assert (len(site.frames), len(site.asked("camera/expose"))) == (3, 4)
    # A star is held again before the frame is begun again.
    guides, frames = site.asked("part/guide"), site.asked("camera/expose")
    assert len(guides) == 2
    assert frames[1] < guides[1] < frames[2]


def test_a_star_that_is_back_in_a_moment_spoils_nothing() -> None:
    guider = Guider()
    site = PureObservatory(parts=guider.parts())
    begin(site, "m31", guiding=Guiding.ON)
    site.until(lambda: len(site.asked("camera/expose")) == 1)
    for _ in range(4):
        guider.lost = "clouds"
        site.pass_time(LOST_S - 3)
        guider.lost = ""
        site.pass_time(2)
    site.until(lambda: ended(site))
    assert (len(site.frames), site.asked("camera/abort")) == (3, [])


def test_a_star_that_is_lost_in_every_exposure_fails_the_request_and_keeps_its_frames() -> None:
    guider = Guider()
    site = PureObservatory(parts=guider.parts())
    begin(site, "m31", guiding=Guiding.ON)
    site.until(lambda: len(site.frames) == 1)
    while not ended(site):
        exposing = len(site.asked("camera/expose")) > len(site.frames) + len(
            site.asked("camera/abort")
        )
        guider.lost = "clouds" if exposing else ""
        site.pass_time(1)
    (change,) = [one for one in site.changes if one.state is S.FAILED]
    assert change.frames_done == (1,)
    assert "clouds during 2 exposures" in change.why
    assert len(site.asked("camera/abort")) == site.night.step_tries


def test_a_frame_that_can_do_without_a_star_goes_on() -> None:
    guider = Guider()
    site = PureObservatory(parts=guider.parts())
    begin(site, "m31")
    site.until(lambda: len(site.asked("camera/expose")) == 1)
    guider.lost = "clouds"
    site.until(lambda: ended(site))
    assert (site.frames, site.asked("camera/abort")) == (["m31"] * 3, [])


def test_nothing_is_exposed_until_the_mount_says_that_it_tracks() -> None:
    site = PureObservatory(track=None)
    begin(site, "m31")
    site.until(lambda: bool(site.asked("telescope/goto")))
    while not ended(site):
        # It does not go on from the slew to tracking.
        site.tracks = False
        site.pass_time(1)
    assert site.changes[-1].state is S.FAILED
    assert "waiting until it tracks" in site.changes[-1].why
    assert site.asked("camera/expose") == []


def test_a_mount_that_stands_after_its_slew_is_made_to_track() -> None:
    site = PureObservatory()
    begin(site, "m31")
    site.until(lambda: site.tracks)
    site.tracks = False
    site.until(lambda: ended(site))
    assert len(site.asked("telescope/track")) == 1
    assert site.frames == ["m31"] * 3
    # Each frame was begun while it tracked.
    assert all(view.tracking for _, name, view in site.ledger if name == "camera/expose")


def test_a_frame_in_which_the_mount_stops_is_taken_again_where_it_was_to_point() -> None:
    site = PureObservatory()
    begin(site, "m31")
    site.until(lambda: len(site.asked("camera/expose")) == 2)
    site.pass_time(5)
    site.tracks = False
    site.until(lambda: ended(site))
    assert site.frames == ["m31"] * 3
    assert len(site.asked("camera/expose")) == 4
    assert len(site.asked("telescope/goto")) == 2


def test_a_fixed_direction_is_pointed_at_and_neither_tracked_nor_guided_nor_focused_on() -> None:
    parts = BlockParts(guides=True, solves=True, focus_due=lambda _name, _time: True)
    site = PureObservatory(parts=parts)
    fixed = FixedTarget(name="pole side", altitude=60.0, azimuth=20.0)
    begin(site, "fixed", target=fixed, dither=10.0, guiding=Guiding.ON)
    site.until(lambda: ended(site))
    assert site.frames == ["pole side"] * 3
    names = [name for _, name, _ in site.ledger]
    assert names.count("telescope/goto_altaz") == 1
    assert {"alt": 60.0, "az": 20.0} in site.args
    assert not [name for name in names if name.startswith("part/") or name == "telescope/goto"]
    assert all(view.tracking is False for _, name, view in site.ledger if name == "camera/expose")


def test_a_fixed_direction_is_not_exposed_while_the_mount_tracks() -> None:
    site = PureObservatory()
    begin(site, "fixed", target=FixedTarget(altitude=60.0, azimuth=20.0))
    site.until(lambda: bool(site.asked("telescope/goto_altaz")))
    while not ended(site):
        site.tracks = True
        site.pass_time(1)
    assert site.changes[-1].state is S.FAILED
    assert site.asked("camera/expose") == []


@pytest.mark.parametrize("flip_after", [0.0, 900.0])
def test_a_mount_turns_over_behind_the_last_frame_that_it_may_take(flip_after: float) -> None:
    night = example_site().night
    assert night is not None
    guider = Guider()
    site = PureObservatory(
        parts=guider.parts(),
        times=replace(night.times, meridian_flip=60.0),
        flip_after=flip_after,
    )
    # Twelve minutes before the meridian; frames of five.
    begin(site, "m31", hours_east=0.2, frames=8, seconds=300.0)
    site.until(lambda: ended(site))
    assert site.frames == ["m31"] * 8
    place = example_site().place
    assert place is not None
    slews, sent = site.asked("telescope/goto"), [args for args in site.args if "ra" in args]
    assert len(slews) == 2
    flip, where = slews[1], (sent[1]["ra"], sent[1]["dec"])
    passed = hour_angle_of(where, place, EVENING + flip) * 3600.0  # type: ignore[arg-type]
    # Never before the meridian, and no frame across what the mount may track.
    assert passed >= 0.0
    starts = site.asked("camera/expose")
    before = [at for at in starts if at < flip]
    last = hour_angle_of(where, place, EVENING + before[-1] + 300.0) * 3600.0  # type: ignore[arg-type]
    assert last <= flip_after + 3.0
    assert last > flip_after - 320.0
    # The star is let go before it and held again behind it.
    order = [
        name for at, name, _ in site.ledger if abs(at - flip) < 120.0 and name != "camera/expose"
    ]
    kinds = [name for name in order if name in {"part/unguide", "telescope/goto", "part/guide"}]
    assert ("part/unguide", "telescope/goto") in pairwise(kinds)
    assert ("telescope/goto", "part/guide") in pairwise(kinds)
