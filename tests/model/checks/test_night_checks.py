"""What does not fit in ``night:`` is found, and said with what to do."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from msgspec.structs import replace

from talaia.model.checks.site_checks import check_site
from talaia.model.derivation.source import DerivedSource
from talaia.model.interlocks.enclosure import Sighting
from talaia.model.interlocks.interlock import Step
from talaia.model.night_frames import (
    FilterCommand,
    FrameCommand,
    NightDarks,
    NightField,
    RotatorCommand,
)
from talaia.model.night_section import NightFocuser, NightSection, NightSun, SlewCommand
from talaia.model.observing.plan import Instrument
from talaia.model.roles import SignalRole
from talaia.model.yaml_text.load import load_site

if TYPE_CHECKING:
    from talaia.model.site import Site

pytestmark = pytest.mark.pure
EXAMPLES = Path(__file__).parents[3] / "examples"


@cache
def observatory() -> Site:
    return load_site((EXAMPLES / "observatory" / "site.yaml").read_text())


def night(**changes: object) -> Site:
    site = observatory()
    assert site.night is not None
    return replace(site, night=replace(site.night, **changes))


def field_turned_by(
    command: str = "focuser/goto", argument: str = "position", **more: Any
) -> NightField:
    """Describe a camera that turns by the command of another device."""
    rotator = RotatorCommand(command=command, argument=argument, **more)
    return NightField(width=0.2, height=0.1, rotator=rotator)


def test_a_bias_may_have_no_argument_for_its_length() -> None:
    bias = FrameCommand(command="camera/abort", seconds="")
    assert check_site(night(bias=bias)) == []


def test_a_rotator_is_a_device_and_its_angle_a_reading_of_the_night() -> None:
    site = night(field=field_turned_by(reading="focuser/position"))
    assert site.night is not None
    assert "focuser/goto" in site.night.commands()
    assert "focuser/position" in site.night.readings(site.devices)


def test_where_a_telescope_points_is_read_by_roles_and_stays_at_hand() -> None:
    site = night()
    assert site.night is not None
    angles = ("telescope/altitude", "telescope/azimuth")
    assert site.night.angles(site.devices) == angles
    assert set(angles) <= site.safety_signals()
    # Without the roles nobody knows, and nothing is guessed.
    telescope = site.devices["telescope"]
    plain = {
        name: replace(signal, role=SignalRole.NONE) for name, signal in telescope.signals.items()
    }
    devices = {**site.devices, "telescope": replace(telescope, signals=plain)}
    assert site.night.angles(devices) == ("", "")


def test_an_altitude_that_is_worked_out_is_not_read_and_no_mistake() -> None:
    site = night()
    assert site.night is not None
    telescope = site.devices["telescope"]
    worked_out = replace(
        telescope.signals["altitude"],
        source=DerivedSource(expression="{telescope/dec} + {telescope/sun_altitude}"),
    )
    signals = {**telescope.signals, "altitude": worked_out}
    devices = {**site.devices, "telescope": replace(telescope, signals=signals)}
    assert site.night.angles(devices) == ("", "telescope/azimuth")
    before = {str(finding) for finding in check_site(site)}
    found = {str(finding) for finding in check_site(replace(site, devices=devices))}
    assert not any("altitude" in finding for finding in found - before), found - before


@pytest.mark.parametrize("example", ["observatory", "indi"])
def test_the_examples_observe_by_themselves_and_fit(example: str) -> None:
    site = load_site((EXAMPLES / example / "site.yaml").read_text())
    assert isinstance(site.night, NightSection)
    assert check_site(site) == []


@pytest.mark.parametrize(
    ("changes", "where"),
    [
        ({"enclosure": "roof"}, "$.night.enclosure"),
        ({"opened": Sighting(signal="dome/lid", is_one_of=("open",))}, "$.night.opened.signal"),
        ({"open": Step(command="dome/opn")}, "$.night.open.command"),
        ({"open": Step(command="power/outlet8")}, "$.night.open.command"),
        ({"start": (Step(command="camera/cool", args={"celsius": 99}),)}, "$.night.start[0].args"),
        ({"slew": SlewCommand(command="telescope/gto")}, "$.night.slew.command"),
        ({"slew": SlewCommand(command="telescope/goto", ra="x")}, "$.night.slew.ra"),
        (
            {"light": FrameCommand(command="camera/expose", seconds="target")},
            "$.night.light.seconds",
        ),
        ({"light": FrameCommand(command="camera/expose", seconds="")}, "$.night.light.seconds"),
        ({"light": FrameCommand(command="camera/expose", args={"no": 1})}, "$.night.light.args.no"),
        ({"field": NightField(width=0.0, height=0.1)}, "$.night.field.width"),
        ({"field": NightField(width=0.1, height=90.0)}, "$.night.field.height"),
        (
            {"field": NightField(width=0.1, height=0.1, position_angle=-5.0)},
            "$.night.field.position_angle",
        ),
        ({"field": field_turned_by("focuser/turn")}, "$.night.field.rotator.command"),
        ({"field": field_turned_by(argument="angle")}, "$.night.field.rotator.argument"),
        ({"field": field_turned_by(argument="")}, "$.night.field.rotator.argument"),
        ({"field": field_turned_by(reading="dome/shutter")}, "$.night.field.rotator.reading"),
        ({"field": field_turned_by(zero=999.0)}, "$.night.field.rotator.zero"),
        ({"field": field_turned_by(within=0.0)}, "$.night.field.rotator.within"),
        (
            {"darks": NightDarks(command=FrameCommand(command="camera/drk"))},
            "$.night.darks.command.command",
        ),
        (
            {"filter": FilterCommand(command="camera/cool", argument="slot", filters={"R": 1})},
            "$.night.filter.argument",
        ),
        (
            {"filter": FilterCommand(command="camera/cool", argument="celsius", filters={})},
            "$.night.filter.filters",
        ),
        ({"clouds": "weather/cloud"}, "$.night.clouds"),
        ({"clouds": "dome/shutter"}, "$.night.clouds"),
        ({"sun": NightSun(opening=-5.0)}, "$.night.sun"),
        ({"sun": NightSun(observing=float("nan"))}, "$.night.sun"),
        ({"times": Instrument(slew_rate=0.0)}, "$.night.times.slew_rate"),
        ({"times": Instrument(horizon=-3.0)}, "$.night.times.horizon"),
        ({"step_tries": 0}, "$.night.step_tries"),
        ({"failure_limit": 0}, "$.night.failure_limit"),
        ({"hand_over": -1.0}, "$.night.hand_over"),
    ],
)
def test_what_does_not_fit_is_found_where_it_stands(changes: dict[str, object], where: str) -> None:
    assert {finding.where for finding in check_site(night(**changes))} == {where}


def test_a_roof_that_no_interlock_keeps_from_opening_is_not_opened_by_a_machine() -> None:
    site = observatory()
    free = {name: replace(rule, refuse=()) for name, rule in site.interlocks.items()}
    found = [finding.where for finding in check_site(replace(site, interlocks=free))]
    assert {"$.night.open.command", "$.night.unpark.command"} <= set(found)


def test_nobody_observes_by_night_where_no_place_is_known() -> None:
    # Without a place neither night nor day is known, nor where a telescope may point.
    site = replace(observatory(), place=None)
    assert "$.night" in [finding.where for finding in check_site(site)]


def test_what_the_night_goes_by_stays_at_hand_as_what_safety_goes_by() -> None:
    assert {"dome/shutter", "allsky/clouds"} <= observatory().safety_signals()


def test_what_focus_and_camera_settings_go_by_stays_at_hand_too() -> None:
    site = night(
        focuser=NightFocuser(
            command="focuser/goto", position="focuser/position", temperature="focuser/temperature"
        )
    )
    assert {
        "focuser/position",
        "focuser/temperature",
        "camera/binning",
        "camera/gain",
    } <= site.safety_signals()


def test_what_says_that_the_telescope_tracks_stays_at_hand_whatever_the_roof_goes_by() -> None:
    site = night(tracking=Sighting(signal="wheel/position", is_one_of=("L",)))
    assert "wheel/position" in site.safety_signals()
