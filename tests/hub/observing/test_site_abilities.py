"""What a site cannot do for a request is refused in words before it is handed in."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from talaia.hub.observing.site_abilities import site_abilities, site_problems
from talaia.model.night_frames import NightField
from talaia.model.night_section import NightGuider
from talaia.model.observing.requests import (
    Configuration,
    Constraints,
    Guiding,
    ImageType,
    Request,
    RequestGroup,
    Window,
)
from talaia.model.observing.targets import IcrsTarget
from talaia.model.site import Site
from talaia.model.yaml_text.load import load_site

pytestmark = pytest.mark.pure
EXAMPLES = Path(__file__).parents[3] / "examples"


@cache
def example(name: str) -> Site:
    return load_site((EXAMPLES / name / "site.yaml").read_text())


def site_with(name: str = "observatory", **changes: Any) -> Site:
    site = example(name)
    assert site.night is not None
    return replace(site, night=replace(site.night, **changes))


def problems(site: Site, *wanted: Configuration, target: bool = True) -> list[str]:
    request = Request(
        id="r1",
        target=IcrsTarget(ra=10.0, dec=41.0) if target else None,
        configurations=wanted,
        windows=(Window(start=0.0, end=1.0),),
    )
    return site_problems(RequestGroup(id="g1", proposal="school", requests=(request,)), site)


def part(**changes: Any) -> Configuration:
    return Configuration(exposure=10.0, **changes)


@pytest.mark.parametrize("name", ["observatory", "indi"])
def test_the_examples_choose_binning_and_gain(name: str) -> None:
    assert problems(example(name), part(), part(binning=2, gain=50.0)) == []


@pytest.mark.parametrize("name", ["observatory", "indi"])
def test_a_site_that_cannot_choose_says_so_once(name: str) -> None:
    site = site_with(name, binning=None, gain=None)
    assert problems(site, part()) == []
    asked = part(binning=2, gain=50.0)
    assert problems(site, asked, asked) == [
        "this site cannot choose binning",
        "this site cannot choose gain",
    ]


def test_a_number_that_the_command_does_not_take_is_refused_with_its_limits() -> None:
    assert problems(example("observatory"), part(binning=8, gain=400.0)) == [
        "binning 8 cannot be: it goes from 1 to 4",
        "gain 400 cannot be: it goes from 0 to 300",
    ]


def test_guiding_that_must_be_needs_a_guider() -> None:
    asked = part(guiding=Guiding.ON)
    assert problems(site_with(), asked) == [
        "this site has no guider: guiding may be OFF or OPTIONAL"
    ]
    assert problems(site_with(guider=NightGuider()), asked) == []
    assert problems(site_with(), part(guiding=Guiding.OPTIONAL)) == []


def test_calibrations_are_taken_where_the_description_says_how() -> None:
    site = example("observatory")
    for kind in ImageType:
        seconds = 0.0 if kind is ImageType.BIAS else 10.0
        assert problems(site, Configuration(type=kind, exposure=seconds)) == []
        seconds = 0.0 if kind is ImageType.BIAS else 10.0
        assert problems(example("indi"), Configuration(type=kind, exposure=seconds)) == []
    bare = site_with("indi", darks=None, bias=None, flats=None)
    for kind in ("DARK", "BIAS", "SKY_FLAT"):
        assert problems(bare, part(type=ImageType(kind))) == [
            f"the nights of this site take no {kind} frames for requests"
        ]


def test_an_exposure_that_the_camera_does_not_take_is_refused() -> None:
    assert problems(example("observatory"), Configuration(exposure=4000.0)) == [
        "an exposure of 4000 cannot be: it goes from 0.04 to 3600"
    ]


def test_frames_of_the_sky_and_of_a_closed_roof_are_no_one_request() -> None:
    site = example("observatory")
    dark, bias = part(type=ImageType.DARK), Configuration(type=ImageType.BIAS, exposure=0.0)
    assert problems(site, dark, bias) == []
    assert "not of several of them" in problems(site, dark, part())[0]
    assert "not of several of them" in problems(site, dark, part(type=ImageType.SKY_FLAT))[0]


def test_a_form_is_told_what_its_site_can_do() -> None:
    able = site_abilities(example("observatory"))
    assert able is not None
    assert able.filters == ("L", "R", "G", "B", "Ha")
    assert able.types == tuple(ImageType)
    assert able.binning is not None
    assert not able.guides
    plain = site_abilities(site_with(filter=None, binning=None, gain=None, bias=None, flats=None))
    assert plain is not None
    assert (plain.filters, plain.binning, plain.gain) == (None, None, None)
    assert plain.types == (ImageType.LIGHT, ImageType.DARK)
    assert site_abilities(example("agv")) is None


def angle_problems(site: Site, angle: float | None) -> list[str]:
    request = Request(
        id="r1",
        target=IcrsTarget(ra=10.0, dec=41.0, position_angle=angle),
        configurations=(part(),),
        windows=(Window(start=0.0, end=1.0),),
    )
    return site_problems(RequestGroup(id="g1", proposal="school", requests=(request,)), site)


def test_a_camera_that_does_not_turn_takes_only_the_angle_at_which_it_stands() -> None:
    site = site_with(field=NightField(width=0.2, height=0.1, position_angle=40.0))
    # Upside down it is the same rectangle.
    for angle in (None, 40.0, 220.0, 39.5):
        assert angle_problems(site, angle) == []
    assert angle_problems(site, 90.0) == [
        "the camera stands at a position angle of 40° and cannot be turned to 90°"
    ]
    assert angle_problems(site_with(field=None), 90.0) == [
        "this site does not say how its camera stands: leave the position angle open"
    ]


def test_a_camera_with_a_rotator_takes_any_angle_and_its_field_is_told() -> None:
    site = example("indi")
    assert angle_problems(site, 123.4) == []
    abilities = site_abilities(site)
    assert abilities is not None
    assert abilities.field is not None
    assert (abilities.field.width, abilities.field.rotator is not None) == (0.4238, True)


def test_a_light_frame_without_a_target_is_refused_and_what_needs_none_is_not() -> None:
    site = example("observatory")
    assert problems(site, part(), target=False) == ["a LIGHT frame is of a target: name one"]
    for kind in (ImageType.DARK, ImageType.SKY_FLAT):
        assert problems(site, part(type=kind), target=False) == []


def limit_problems(site: Site, **limits: Any) -> list[str]:
    request = Request(
        id="r1",
        target=IcrsTarget(ra=10.0, dec=41.0),
        configurations=(part(),),
        constraints=Constraints(**limits),
        windows=(Window(start=0.0, end=1.0),),
    )
    return site_problems(RequestGroup(id="g1", proposal="school", requests=(request,)), site)


def test_a_limit_on_what_a_site_does_not_measure_is_refused_since_it_would_hold_nothing() -> None:
    blind = site_with(clouds="", seeing="", centring=None)
    assert limit_problems(blind, max_clouds=20.0, max_seeing=2.0) == [
        "this site does not measure the seeing: leave its limit open",
        "this site does not measure clouds: leave their limit open",
    ]
    # The stars of each field that is centred, or an instrument of its own.
    measured = [site_with(), site_with(centring=None, seeing="weather/wind")]
    for site in measured:
        assert limit_problems(site, max_clouds=20.0, max_seeing=2.0) == []
    told = [site_abilities(site) for site in (blind, *measured)]
    assert [(one.measures_seeing, one.measures_clouds) for one in told if one is not None] == [
        (False, False),
        (True, True),
        (True, True),
    ]
