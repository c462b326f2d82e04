"""What a robot itself says of its motion: how fast it is, and whether it stands."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.gateway.driving.stop_latch import StandstillProof

if TYPE_CHECKING:
    from talaia.gateway.ports import ReadingSource
    from talaia.model.site import Drive as DriveRule, Site

__all__ = ["MotionReadings"]


# How old it may be where a joint stands, for that to bound its speed: see `END_S` of the limits.
JOINT_AGE_NS = SECOND // 4


class MotionReadings:
    """Reads the signals that the description of driving names."""

    def __init__(self, site: Site, readings: ReadingSource) -> None:
        """Read by a description."""
        self._site = site
        self._readings = readings

    def redescribe(self, site: Site) -> None:
        """Read by another description from here on."""
        self._site = site

    def measured_velocity(self, rule: DriveRule, now_ns: int) -> tuple[float, float]:
        """Give what a robot that is driven by characters says of its motion; NaN for nothing."""
        keys = rule.keys
        speed, turn = (self._fresh_value(address, now_ns) for address in (keys.speed, keys.turn))
        return speed, turn

    def joint_places(self, rule: DriveRule, now_ns: int) -> tuple[float, ...]:
        """Give where each driven joint stands (rad or m); NaN where that is not known now."""
        places = []
        for joint in rule.joints.values():
            reading = self._readings.latest(joint.position) if joint.position else None
            fresh = reading is not None and now_ns - reading.mono_ns <= JOINT_AGE_NS
            places.append(reading.value if fresh and reading is not None else math.nan)
        return tuple(places)

    def standstill_proofs(self, rule: DriveRule) -> list[StandstillProof | None]:
        """Give what each signal that confirms STOP says; none for one that says nothing."""
        proofs: list[StandstillProof | None] = []
        for address in rule.stop.confirmed_by:
            # The newest value with the time at which it came; its age is judged by `StopLatch`.
            reading = self._readings.latest(address)
            max_age = self._max_age(address)
            proofs.append(
                None
                if reading is None
                else StandstillProof(reading.value, reading.mono_ns, round(max_age * SECOND))
            )
        return proofs

    def _fresh_value(self, address: str, now_ns: int) -> float:
        reading = self._readings.latest(address) if address else None
        if reading is None:
            return math.nan
        max_age_ns = round(self._max_age(address) * SECOND)
        # An old speed would let a character through that the robot's true speed forbids; NaN says
        # unknown.
        return reading.value if now_ns - reading.mono_ns <= max_age_ns else math.nan

    def _max_age(self, address: str) -> float:
        device, _, signal = address.partition("/")
        return self._site.devices[device].signals[signal].max_age
