"""Conditions on what no sensor says by itself: a dew point that comes near, a Sun that rises."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, strategies as st

from talaia.clock import SECOND
from talaia.gateway.ports import ChannelReading
from talaia.gateway.safety.interlocks import Interlocks
from talaia.model.checks.site_checks import check_site
from talaia.model.units.dew_point import dew_point
from talaia.model.yaml_text.load import dump_site, load_site

if TYPE_CHECKING:
    from collections.abc import Sequence

DESCRIPTION = """
talaia: 1
site: s
name: S
place: {latitude: 0, longitude: 0}
ros2: {}
devices:
  weather:
    name: Weather
    signals:
      temperature:
        {name: Temperature, unit: °C, minimum: -40, maximum: 60,
         source: {topic: /t, type: std_msgs/msg/Float64, field: data}}
      dew_point:
        {name: Dew point, unit: °C, minimum: -60, maximum: 60,
         source: {topic: /d, type: std_msgs/msg/Float64, field: data}}
      humidity:
        {name: Humidity, unit: "%", minimum: 0, maximum: 100,
         source: {topic: /h, type: std_msgs/msg/Float64, field: data}}
      rain:
        {name: Rain, type: state, states: [dry, wet],
         source: {topic: /r, type: std_msgs/msg/Bool, field: data}}
  dome:
    name: Dome
    commands:
      open: {name: Open, target: /open, type: std_srvs/srv/Trigger}
interlocks:
  weather:
    name: Weather
    when: [{signal: weather/temperature, minus: weather/dew_point, below: 3, until_above: 4}]
    refuse: [dome/open]
    dwell: 0
"""
MINUS = "{signal: weather/temperature, minus: weather/dew_point, below: 3, until_above: 4}"
HUMID = "{signal: weather/temperature, humidity: weather/humidity, below: 3, until_above: 4}"
SUN = "{sun: altitude, above: -6, until_below: -8}"
# The equinox of March 2026 on the equator, at noon: the Sun in the zenith, within a degree.
NOON_S = 1_774_008_000


class Roof:
    """Interlocks whose newest values and clock are given."""

    def __init__(self, condition: str = MINUS) -> None:  # noqa: D107
        self.site = load_site(DESCRIPTION.replace(MINUS, condition))
        assert check_site(self.site) == []
        self.now = 0
        self.wall_s = float(NOON_S)
        self.values = {"temperature": 15.0, "dew_point": 5.0, "humidity": 50.0}
        self.interlocks = Interlocks(
            site=self.site,
            readings=self,
            output=self,
            run=lambda *_: None,
            now_ns=0,
            wall_ns=lambda: round(self.wall_s * SECOND),
        )

    def latest(self, address: str) -> ChannelReading | None:
        value = self.values.get(address.partition("/")[2])
        return None if value is None else ChannelReading(value, self.now)

    def send(self, message: object) -> None: ...

    def record_event(self, kind: str, *_more: object, **_good: object) -> None: ...

    def says(self, **values: float | None) -> str:
        self.values |= {name: value for name, value in values.items() if value is not None}
        for name in [name for name, value in values.items() if value is None]:
            del self.values[name]
        self.now += SECOND
        self.interlocks.evaluate_all(self.now)
        return self.interlocks.refusal_reason("dome", "open", self.now)


def test_a_dew_point_near_the_temperature_is_unsafe_until_it_is_farther_away_again() -> None:
    roof = Roof()
    assert roof.says() == ""
    assert "Temperature minus Dew point is below" in roof.says(dew_point=12.1)
    assert roof.says(dew_point=11.5) != ""
    assert roof.says(dew_point=10.9) == ""
    assert roof.says(dew_point=11.5) == ""


@pytest.mark.parametrize("name", ["temperature", "dew_point"])
@pytest.mark.parametrize("value", [None, math.nan, -999.0])
def test_a_difference_of_which_one_is_unknown_is_unknown_and_unsafe(
    name: str, value: float | None
) -> None:
    roof = Roof()
    assert roof.says() == ""
    assert roof.says(**{name: value}) != ""


def test_where_the_station_gives_no_dew_point_it_is_computed_from_the_humidity() -> None:
    roof = Roof(HUMID)
    assert roof.says() == ""
    # 15 °C at 85 %: the dew point is 12.5 °C.
    assert "Temperature minus dew point is below" in roof.says(humidity=85.0)
    assert roof.says(humidity=80.0) != ""
    assert roof.says(humidity=75.0) == ""
    assert "no dew point" in roof.says(humidity=0.0)


# From the table of dew points of the U.S. National Weather Service's calculator, to 0.1 °C.
@pytest.mark.parametrize(
    ("temperature", "humidity", "expected"),
    [(20, 50, 9.3), (0, 100, 0.0), (30, 70, 23.9), (-10, 80, -12.8), (25, 10, -8.8)],
)
def test_the_dew_point_is_that_of_the_tables(
    temperature: float, humidity: float, expected: float
) -> None:
    assert dew_point(temperature, humidity) == pytest.approx(expected, abs=0.1)


@given(st.floats(-60, 60), st.floats(0.1, 100))
def test_the_dew_point_is_never_above_the_temperature(temperature: float, humidity: float) -> None:
    assert dew_point(temperature, humidity) <= temperature + 1e-9


@given(st.floats(), st.floats())
def test_a_dew_point_is_a_number_or_none_whatever_a_station_says(a: float, b: float) -> None:
    assert isinstance(dew_point(a, b), float)


def test_the_sun_locks_as_it_rises_and_lets_go_when_it_is_lower_again() -> None:
    roof = Roof(SUN)
    # On the equator at the equinox the Sun goes 15° an hour.
    for hours, safe in ((-7, True), (-6.35, True), (-6.2, False), (-6.35, False), (-6.6, True)):
        roof.wall_s = NOON_S + hours * 3600
        assert (roof.says() == "") is safe, hours
    roof.wall_s = NOON_S
    assert "The Sun's altitude is above" in roof.says()


MISTAKES: Sequence[tuple[str, str, str, str]] = [
    (SUN, "place: {latitude: 0, longitude: 0}\n", "when[0]", "where the site is"),
    ("{sun: altitude}", "", "when[0]", "no limit"),
    ("{sun: altitude, above: -6, signal: weather/humidity}", "", "when[0]", "both signal and sun"),
    ("{sun: altitude, above: -6, until_below: -4}", "", "until_below", "beyond the limit"),
    ("{sun: altitude, above: -6, link_lost: 3}", "", "when[0]", "both sun and link_lost"),
    (MINUS.replace("dew_point,", "dew,"), "", "when[0].minus", "weather/dew"),
    (MINUS.replace("dew_point,", "humidity,"), "", "when[0].minus", "is in %"),
    (MINUS.replace("dew_point,", "rain,"), "", "when[0].minus", "weather/rain"),
    (MINUS.replace(", below: 3, until_above: 4", ""), "", "when[0]", "no limit"),
    (HUMID.replace("weather/humidity", "weather/dew_point"), "", "humidity", "in °C and a"),
    (HUMID.replace("{", "{minus: weather/dew_point, "), "", "when[0]", "both minus and humidity"),
]


@pytest.mark.parametrize(("condition", "without", "where", "problem"), MISTAKES)
def test_a_mistake_in_a_condition_is_told(
    condition: str, without: str, where: str, problem: str
) -> None:
    text = DESCRIPTION.replace(MINUS, condition)
    findings = check_site(load_site(text.replace(without, "") if without else text))
    assert [one for one in findings if where in one.where and problem in one.problem], findings


def test_a_description_with_them_survives_a_round_trip() -> None:
    for condition in (MINUS, HUMID, SUN):
        site = load_site(DESCRIPTION.replace(MINUS, condition))
        assert load_site(dump_site(site)) == site
