"""What the simulated vehicle says of its health."""

from __future__ import annotations

import pytest

from talaia.sim.vehicle.drives.kinematics import side_rates
from talaia.sim.vehicle.self_check import HealthLevel, MotorHeat, check_vehicle
from talaia.sim.vehicle.sensors import Battery

pytestmark = pytest.mark.pure


def checked(*, charge=0.97, speed=0.0, heat=None, camera=True, stopped=False):
    found = check_vehicle(
        battery=Battery(charge),
        motors={
            side: (motor, rate)
            for side, motor, rate in zip(
                ("left", "right"),
                heat or (MotorHeat(), MotorHeat()),
                side_rates(speed, 0.0),
                strict=True,
            )
        },
        camera=camera,
        stopped=stopped,
    )
    return {status.name: status for status in found}


def test_a_vehicle_in_order_says_so_of_each_part() -> None:
    found = checked()
    assert {status.level for status in found.values()} == {HealthLevel.OK}
    assert list(found) == [
        "battery: cells",
        "base: left motor",
        "base: right motor",
        "camera: front",
        "base: STOP",
    ]
    assert found["battery: cells"].values["charge"] == "97 %"
    # Without a camera nothing is said of one.
    assert "camera: front" not in checked(camera=None)


def test_what_is_low_latched_or_ended_is_told_by_its_level() -> None:
    assert checked(charge=0.15)["battery: cells"].level is HealthLevel.WARN
    assert checked(charge=0.08)["battery: cells"].level is HealthLevel.ERROR
    assert checked(stopped=True)["base: STOP"].message == "STOP is latched"
    assert checked(camera=False)["camera: front"].level is HealthLevel.ERROR


def test_motors_warm_by_driving_and_cool_by_standing() -> None:
    heat = MotorHeat()
    begun = heat.celsius
    # Full speed of the demo's vehicle is 6.7 rad/s at each wheel.
    heat.pass_time(600, 6.7)
    assert checked(heat=(heat, MotorHeat()))["base: left motor"].level is HealthLevel.WARN
    assert checked(heat=(heat, MotorHeat()))["base: right motor"].level is HealthLevel.OK
    heat.pass_time(3600, 0)
    assert heat.celsius == pytest.approx(begun, abs=0.1)
