"""What the vehicle says of its own health: battery, motors, camera, STOP. Pure."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import IntEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.sim.vehicle.sensors import Battery

__all__ = ["HealthLevel", "HealthStatus", "MotorHeat", "check_vehicle"]

# Of a charge of 1.
_LOW, _EMPTY = 0.2, 0.1
# °C of a motor's winding.
_WARM, _HOT = 55.0, 75.0


class HealthLevel(IntEnum):
    """As ``diagnostic_msgs/DiagnosticStatus`` counts them."""

    OK = 0
    WARN = 1
    ERROR = 2


@dataclass(frozen=True)
class HealthStatus:
    """One line of the vehicle's health; ``name`` is a path for people, its part first."""

    name: str
    level: HealthLevel
    message: str
    hardware: str
    values: dict[str, str] = field(default_factory=dict)


class MotorHeat:
    """The temperature of one motor's winding: warmer by its load, cooler by the air."""

    # °C for each rad/s in the end, and how long it takes (s): wandering stays below the warning,
    # full speed for some minutes does not.
    _PER_RATE, _SLOW_S = 5.0, 120.0
    _AIR = 23.0

    def __init__(self) -> None:
        """Begin cold."""
        self.celsius = self._AIR

    def pass_time(self, seconds: float, rate: float) -> None:
        """Turn at ``rate`` (rad/s) for a while."""
        # Towards where it would end, the faster the further it is from there.
        goal = self._AIR + self._PER_RATE * abs(rate)
        self.celsius += (goal - self.celsius) * -math.expm1(-seconds / self._SLOW_S)


def check_vehicle(
    *,
    battery: Battery,
    motors: Mapping[str, tuple[MotorHeat, float]],
    camera: bool | None,
    stopped: bool,
) -> list[HealthStatus]:
    """Judge all parts.

    Args:
        battery: its charge.
        motors: the warmth of each and how fast it turns (rad/s), by where it is.
        camera: whether it draws; None where there is none.
        stopped: STOP is latched.

    """
    # By parts, the first word: pages show them as a tree.
    found = [_check_battery(battery)]
    found += [_check_motor(side, motor, rate) for side, (motor, rate) in motors.items()]
    if camera is not None:
        message = "draws" if camera else "its process has ended; there are no more pictures"
        level = HealthLevel.OK if camera else HealthLevel.ERROR
        found.append(HealthStatus("camera: front", level, message, "camera 1"))
    level = HealthLevel.WARN if stopped else HealthLevel.OK
    message = "STOP is latched" if stopped else "ready to drive"
    found.append(HealthStatus("base: STOP", level, message, "base"))
    return found


def _check_battery(battery: Battery) -> HealthStatus:
    level, message = HealthLevel.OK, "in order"
    # The alarm of the example comes between the two.
    if battery.charge < _EMPTY:
        level, message = HealthLevel.ERROR, "nearly empty; drive it to its charger"
    elif battery.charge < _LOW:
        level, message = HealthLevel.WARN, "low"
    values = {
        "charge": f"{battery.charge * 100:.0f} %",
        "voltage": f"{battery.voltage:.2f} V",
        "current": f"{battery.current:.2f} A",
    }
    return HealthStatus("battery: cells", level, message, "battery 1", values)


def _check_motor(side: str, motor: MotorHeat, rate: float) -> HealthStatus:
    level, message = HealthLevel.OK, "in order"
    if motor.celsius > _HOT:
        level, message = HealthLevel.ERROR, "hot; let it stand"
    elif motor.celsius > _WARM:
        level, message = HealthLevel.WARN, "warm"
    values = {"temperature": f"{motor.celsius:.1f} °C", "rate": f"{rate:.2f} rad/s"}
    return HealthStatus(f"base: {side} motor", level, message, f"motor {side}", values)
