"""Battery, temperature and position on Earth."""

from __future__ import annotations

import math

import pytest

from talaia.sim.vehicle.sensors import ORIGIN, Battery, on_earth, room_temperature

pytestmark = pytest.mark.pure


def test_driving_drains_the_battery_faster_than_standing() -> None:
    standing, driving = Battery(0.9), Battery(0.9)
    standing.drain_battery(600.0, 0.0, 0.0)
    driving.drain_battery(600.0, 0.22, 0.0)
    assert driving.charge < standing.charge < 0.9
    assert driving.voltage < standing.voltage


@pytest.mark.parametrize("charge", [1.0, 0.5, 0.06])
def test_the_voltage_is_that_of_three_cells(charge: float) -> None:
    assert 9.0 < Battery(charge).voltage < 12.6


def test_an_empty_battery_is_changed() -> None:
    battery = Battery(0.06)
    battery.drain_battery(3600.0, 0.22, 2.0)
    assert battery.charge > 0.9


def test_a_metre_in_the_house_is_a_metre_on_earth() -> None:
    latitude, longitude, altitude = on_earth(100.0, 200.0)
    assert altitude == ORIGIN[2]
    metres = math.radians(1) * 6_371_000
    assert (latitude - ORIGIN[0]) * metres == pytest.approx(200.0, rel=0.005)
    east = (longitude - ORIGIN[1]) * metres * math.cos(math.radians(ORIGIN[0]))
    assert east == pytest.approx(100.0, rel=0.005)


def test_it_is_warmer_at_the_stove_than_in_bed() -> None:
    assert room_temperature(7.7, -3.3, 0.0) > room_temperature(-1.0, 3.0, 0.0) + 2.0
