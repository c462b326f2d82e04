"""What a request asks of the camera is set before its frames, and judged by its readings."""

from __future__ import annotations

import pytest
from msgspec.structs import replace
from night_observatory import PureObservatory, request

from talaia.gateway.night.frames.frame_settings import FrameSettings
from talaia.gateway.night.night_values import NightView
from talaia.gateway.night.step_runner import StepRunner
from talaia.model.observing.requests import Configuration
from talaia.model.observing.states import ObservationState
from talaia.wire.frames import CommandPhase

pytestmark = pytest.mark.pure


def observed(site: PureObservatory, *, last: str) -> ObservationState:
    """Let what was asked be observed, in order of its names."""
    site.arm()
    site.until(
        lambda: any(
            one.request == last
            and one.state in {ObservationState.COMPLETED, ObservationState.FAILED}
            for one in site.changes
        )
    )
    return site.changes[-1].state


def choose_undone(site: PureObservatory, *names: str) -> None:
    def choose(_question: object) -> str:
        done = {one.request for one in site.changes if one.state is ObservationState.COMPLETED}
        return next((name for name in names if name not in done), "")

    site.choice = choose


def test_binning_and_gain_are_set_before_the_frames_and_only_where_they_differ() -> None:
    site = PureObservatory()
    site.ask(request("a", binning=2, gain=120.0), request("b", binning=2), request("c"))
    choose_undone(site, "a", "b", "c")
    assert observed(site, last="c") is ObservationState.COMPLETED
    names = [name for _, name, _ in site.ledger if name.startswith("camera/")]
    told = [name for name in names if name != "camera/cool"]
    # Of b nothing has to be set; c has the binning that a request has by itself.
    assert told == [
        *("camera/binning", "camera/gain"),
        *["camera/expose"] * 6,
        "camera/binning",
        *["camera/expose"] * 3,
    ]
    assert (site.binning, site.gain) == (1.0, 120.0)


def test_a_binning_that_the_camera_does_not_show_fails_the_block_without_a_frame() -> None:
    site = PureObservatory()
    site.ask(request("a", binning=2))
    choose_undone(site, "a")
    # Its word alone is no binning.
    site.faults["camera/binning"] = CommandPhase.FAILED
    assert observed(site, last="a") is ObservationState.FAILED
    assert site.frames == []
    # Once while the roof opens, where nobody waits for it, and then as often as any step.
    assert len(site.asked("camera/binning")) == 1 + site.night.step_tries
    assert "setting binning 2" in site.changes[-1].why


def test_a_setting_that_no_signal_shows_is_asked_once_and_its_word_counts() -> None:
    night = PureObservatory().night
    assert night.gain is not None
    settings = FrameSettings(replace(night, gain=replace(night.gain, reading="")))
    asked = Configuration(exposure=1.0, gain=50.0)
    view = NightView(now=0.0, time=0.0, sun=-30.0, binning=1.0)
    steps = settings.steps_for(asked, night.light)
    assert [step.words for step in steps] == ["setting binning 1", "setting gain 50"]
    # What is set already is not asked for.
    (ask,) = StepRunner(steps, lambda: "n-1").update_steps(view)
    assert (ask.command, ask.args) == ("camera/gain", {"gain": 50.0})  # type: ignore[union-attr]
    told = steps[1].on_done
    assert told is not None
    told()
    assert [step.words for step in settings.steps_for(asked, night.light)] == ["setting binning 1"]
