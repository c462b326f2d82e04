"""The alarms of the shipped descriptions: silent in a normal hour, raised when it matters."""

# ruff: noqa: D107

from __future__ import annotations

from pathlib import Path

import pytest

from talaia.clock import SECOND
from talaia.hub.alarms.condition_watch import ConditionTurn, ConditionWatch
from talaia.hub.alarms.conditions import AlarmCondition, ConditionReading
from talaia.model.checks.alarm_checks import Addresses
from talaia.model.yaml_text.load import read_site
from talaia.sim.observatory.models.weather import Weather
from talaia.sim.vehicle.sensors import Battery, room_temperature

EXAMPLES = Path(__file__).parents[3] / "examples"
HOUR = 3600


class Alarms:
    """All alarms of a description, on a clock that is turned by hand, a second at a time."""

    def __init__(self, name: str) -> None:
        site = read_site(EXAMPLES / name / "site.yaml")
        addresses = Addresses(site)
        self.states = {at: each.states for at, each in addresses.signals.items()}
        self.watched = {
            key: (AlarmCondition(addresses, alarm), ConditionWatch(alarm, on=False))
            for key, alarm in site.alarms.items()
        }
        self.heard: dict[str, tuple[float, float]] = {}
        self.now_s = 0

    def pass_time(self, seconds: int = 1) -> list[str]:
        """Give what is raised and cleared meanwhile, a cleared one with a minus."""
        told = []
        for _ in range(seconds):
            self.now_s += 1
            readings = {
                at: ConditionReading(value, "", self.now_s - since)
                for at, (value, since) in self.heard.items()
            }
            for key, (condition, watch) in self.watched.items():
                verdict = condition.judge_condition(readings, (), held=watch.on, online=True)
                edge = watch.update_verdict(verdict, self.now_s * SECOND)
                if edge is not None:
                    told.append(key if edge.turn is ConditionTurn.RAISE else f"-{key}")
        return told

    def hear(self, address: str, value: float | str) -> None:
        number = value if isinstance(value, float) else self.states[address].index(value)
        self.heard[address] = (float(number), self.now_s + 1)


def drive(alarms: Alarms, battery: Battery, seconds: int) -> list[str]:
    """Let the vehicle wander, as its simulator does."""
    told = []
    for _ in range(seconds):
        battery.drain_battery(1.0, 0.2, 0.5)
        alarms.hear("power/charge", 100 * battery.charge)
        alarms.hear("sensors/temperature", room_temperature(7.7, -3.3, alarms.now_s))
        told += alarms.pass_time()
    return told


def test_vehicle_is_calm_for_an_hour_and_tells_of_a_low_battery_once() -> None:
    alarms, battery = Alarms("agv"), Battery()
    assert drive(alarms, battery, HOUR) == []
    battery.charge = 0.16
    assert drive(alarms, battery, 200) == ["battery_low"]
    battery.charge = 0.19
    assert drive(alarms, battery, 40) == []
    battery.charge = 1.0
    assert drive(alarms, battery, 40) == ["-battery_low"]


def test_vehicle_that_falls_silent_is_missed_within_a_minute_and_no_blink_is() -> None:
    alarms, battery = Alarms("agv"), Battery()
    # A hub that has just been started hears of it a little later.
    assert alarms.pass_time(30) == []
    assert drive(alarms, battery, 10) == []
    assert alarms.pass_time(50) == []
    assert drive(alarms, battery, 10) == []
    assert alarms.pass_time(62) == ["silent"]
    assert drive(alarms, battery, 1) == ["-silent"]


def observe(alarms: Alarms, weather: Weather, seconds: int) -> list[str]:
    told = []
    for _ in range(seconds):
        weather.step(1.0, alarms.now_s)
        alarms.hear("weather/wind", weather.wind)
        alarms.hear("weather/raining", "wet" if weather.rain > 0 else "dry")
        alarms.hear("dome/shutter", "closed")
        told += alarms.pass_time()
    return told


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_observatory_is_calm_in_fair_weather(seed) -> None:
    assert observe(Alarms("observatory"), Weather(seed, 0.0), HOUR) == []


def test_observatory_tells_of_rain_wind_an_unknown_sky_and_its_dome() -> None:
    alarms, weather = Alarms("observatory"), Weather(1, 0.0)
    weather.force_weather("rain")
    assert observe(alarms, weather, 2) == ["rain"]
    weather.force_weather("clear")
    assert observe(alarms, weather, 299) == []
    assert observe(alarms, weather, 5) == ["-rain"]
    weather.force_weather("wind")
    assert observe(alarms, weather, 12) == ["wind"]
    weather.force_weather("clear")
    assert observe(alarms, weather, 130) == ["-wind"]
    told = []
    for _ in range(7):
        alarms.hear("dome/shutter", "error")
        told += alarms.pass_time()
    assert told == ["dome_error"]
    # Nothing comes any more: an alarm that is on stays, and the weather is missed.
    assert alarms.pass_time(95) == ["no_weather"]
