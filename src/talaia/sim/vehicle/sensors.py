"""Sensors that are not geometry: battery, temperature, position on Earth. Pure."""

from __future__ import annotations

import math

__all__ = ["ORIGIN", "Battery", "on_earth", "room_temperature"]

ORIGIN = (42.0519, 0.7300, 1568.0)
"""Where the vehicle starts: a house near the Montsec observatory in Catalonia (°, °, m)."""


class Battery:
    """A lithium battery of three cells."""

    # As a TurtleBot3's.
    CAPACITY_AH = 1.8
    # Standing still with everything on.
    IDLE_A = 0.35
    PER_SPEED_A = 4.5
    PER_TURN_A = 0.35

    def __init__(self, charge: float = 0.97) -> None:
        """Start with a charge of 0..1."""
        self.charge = charge
        self.current = self.IDLE_A

    def drain_battery(self, seconds: float, speed: float, turn: float) -> None:
        """Let the vehicle draw its current for a while; below 5 % it is taken to be charged."""
        self.current = self.IDLE_A + self.PER_SPEED_A * abs(speed) + self.PER_TURN_A * abs(turn)
        self.charge -= self.current * seconds / (3600.0 * self.CAPACITY_AH)
        if self.charge < 0.05:
            self.charge = 1.0

    @property
    def voltage(self) -> float:
        """At the terminals (V): falls with charge and load."""
        # A lithium cell falls steeply when it is nearly empty.
        knee = 0.9 * math.exp(-self.charge / 0.06)
        return 11.0 + 1.45 * self.charge - knee - 0.12 * self.current


def on_earth(x: float, y: float) -> tuple[float, float, float]:
    """Turn a place in the house into latitude (°), longitude (°) and altitude (m).

    The house's x points east and its y north; within a house the Earth is a plane.
    """
    latitude, longitude, altitude = ORIGIN
    # Metres in a degree on the ellipsoid, to the second term of its series.
    north = 111_132.95 - 559.85 * math.cos(2 * math.radians(latitude))
    east = 111_412.88 * math.cos(math.radians(latitude)) - 93.5 * math.cos(
        3 * math.radians(latitude)
    )
    return latitude + y / north, longitude + x / east, altitude


def room_temperature(x: float, y: float, seconds: float) -> float:
    """Air temperature at a place in the house (°C): warm at the stove, cool in the bedroom."""
    stove = 3.2 * math.exp(-((x - 7.7) ** 2 + (y + 3.3) ** 2) / 3.0)
    lamp = 0.8 * math.exp(-((x + 1.5) ** 2 + (y + 3.5) ** 2) / 1.5)
    return 20.6 - 0.35 * y + stove + lamp + 0.15 * math.sin(seconds / 40.0)
