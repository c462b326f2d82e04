"""What turns the camera before a field is exposed. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.night.step_runner import NightStep
from talaia.model.observing.targets import IcrsTarget

if TYPE_CHECKING:
    from talaia.gateway.night.night_values import NightView
    from talaia.model.night_section import NightSection
    from talaia.model.observing.targets import Target

__all__ = ["turn_steps"]

# So near is near enough (°): at the edge of a field of 1° it is a sixth of an arc minute.
NEAR_DEG = 0.3


def turn_steps(night: NightSection, target: Target | None) -> list[NightStep]:
    """Give what turns the camera so that a picture's top points where a target wants it.

    A mount that has turned over shows the same rectangle upside down: nothing is turned for that.
    """
    rotator = night.rotator
    if rotator is None or not isinstance(target, IcrsTarget) or target.position_angle is None:
        return []
    wanted = rotator.angle_for(target.position_angle)

    def stands_there(view: NightView) -> bool:
        if view.rotator is None:
            return False
        # 359.9° and 0.1° are near each other.
        return abs((view.rotator - wanted + 180.0) % 360.0 - 180.0) <= NEAR_DEG

    return [
        NightStep(
            words=f"turning the camera to {target.position_angle:g}°",
            command=rotator.command,
            args={rotator.argument: wanted},
            within=rotator.within,
            tries=night.step_tries,
            reached=stands_there if rotator.reading else None,
        )
    ]
