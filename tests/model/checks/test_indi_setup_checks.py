"""What is written to INDI drivers after each connect, as a description says it."""

from __future__ import annotations

import pytest

from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.load import dump_site, load_site

SITE = """
talaia: 1
site: test
name: Test
connections: {indi: {kind: indi}}
devices:
  weather:
    name: Weather
    indi: Weather Simulator
    setup: %s
"""
GOOD = (
    "{WEATHER_UPDATE: {PERIOD: 5}, SIMULATION: {ENABLE: true}, ACTIVE_DEVICES: {ACTIVE_GPS: none}}"
)


def test_setup_is_read_checked_and_survives_a_round_trip() -> None:
    site = load_site(SITE % GOOD)
    assert check_site(site) == []
    assert site.devices["weather"].setup["WEATHER_UPDATE"] == {"PERIOD": 5}
    assert site.devices["weather"].setup["SIMULATION"] == {"ENABLE": True}
    assert load_site(dump_site(site)) == site


@pytest.mark.parametrize(
    ("setup", "where", "says"),
    [
        ("{DOME_SHUTTER: {SHUTTER_OPEN: true}}", "DOME_SHUTTER", "a setup moves nothing"),
        ("{TELESCOPE_PARK: {UNPARK: true}}", "TELESCOPE_PARK", "a setup moves nothing"),
        ("{EQUATORIAL_EOD_COORD: {RA: 1}}", "EQUATORIAL_EOD_COORD", "a setup moves nothing"),
        ("{WEATHER_OVERRIDE: {OVERRIDE: true}}", "WEATHER_OVERRIDE", "a setup moves nothing"),
        ("{WEATHER_UPDATE: {}}", "WEATHER_UPDATE", "no element is named"),
        ("{WEATHER_UPDATE: {PERIOD: .nan}}", "WEATHER_UPDATE.PERIOD", "expected a finite number"),
    ],
)
def test_setup_that_moves_or_says_nothing_is_told_with_its_place(
    setup: str, where: str, says: str
) -> None:
    found = check_site(load_site(SITE % setup))
    assert [(each.where, says in each.problem) for each in found] == [
        (f"$.devices.weather.setup.{where}", True)
    ]


@pytest.mark.parametrize("name", ["DOME_SHUTTER_PARK_POLICY", "TELESCOPE_PARK_OPTION"])
def test_policies_that_only_sound_like_motion_may_be_set(name: str) -> None:
    assert check_site(load_site(SITE % f"{{{name}: {{A: true}}}}")) == []


def test_setup_of_a_device_that_is_no_indi_driver_is_told() -> None:
    text = (SITE % GOOD).replace("    indi: Weather Simulator\n", "")
    assert any("only INDI drivers" in each.problem for each in check_site(load_site(text)))
