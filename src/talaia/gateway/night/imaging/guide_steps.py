"""Guiding and dithering of one block, as steps between its frames. Pure."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.model.observing.requests import Guiding

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.night.block_run import BlockParts
    from talaia.gateway.night.step_runner import NightStep
    from talaia.gateway.night.target_place import EquatorialPlace
    from talaia.model.observing.requests import Configuration

    # Words and name of a part, whether it must succeed, and how far it dithers (″).
    MakePart = Callable[..., NightStep]

__all__ = ["GuideSteps", "dithered_place"]

# Guiding that a request can do without is begun again so long after it was, at the earliest (s).
GUIDE_AGAIN_S = 600.0
# Turned by this from frame to frame, no two offsets of a block are near each other (°).
_GOLDEN_ANGLE = 137.507_764
_GOLDEN_SHARE = 0.618_034


class GuideSteps:
    """See the module.

    Attributes:
        guided: a star is held, or was when it was last begun.
        dither_due: a frame has been read out since the field was moved last.

    """

    def __init__(self, parts: BlockParts, make_part: MakePart) -> None:
        """Begin with no star held."""
        self._parts, self._make_part = parts, make_part
        self.guided = self.dither_due = False
        # When guiding that was lost may be begun again (monotonic, s).
        self._again_from = 0.0

    def steps_for(self, configuration: Configuration, now: float) -> list[NightStep]:
        """Give what leads to a star that is held as a frame asks for it."""
        if configuration.guiding is Guiding.OFF:
            return self.stop_steps()
        must = configuration.guiding is Guiding.ON
        if not self._parts.guides and not must:
            return []
        if self.guided:
            lost = self._parts.guide_lost()
            if lost and now >= self._again_from:
                # The field has drifted meanwhile by less than centring is worth.
                return [self._guide(f"guiding again, for {lost}", required=must, now=now)]
            if lost or not (self.dither_due and configuration.dither):
                return []
            self.dither_due = False
            dither = configuration.dither
            return [self._make_part("dithering", "dither", required=must, dither=dither)]
        return [self._guide("guiding", required=must, now=now)]

    def stop_steps(self) -> list[NightStep]:
        """Give what lets the star go, where one is held."""
        guided, self.guided = self.guided, False
        if not (guided and self._parts.guides):
            return []
        return [self._make_part("ending guiding", "unguide", required=False)]

    def dithers_by_mount(self, configuration: Configuration) -> bool:
        """Tell whether the next frame wants another place, and no guider brings it there."""
        held = self.guided and self._parts.guides
        return bool(configuration.dither) and self.dither_due and not held

    def _guide(self, words: str, *, required: bool, now: float) -> NightStep:
        self.guided = True
        # A request that must be guided fails by the tries of the step, and waits for nothing.
        self._again_from = now if required else now + GUIDE_AGAIN_S
        return self._make_part(words, "guide", required=required)


def dithered_place(middle: EquatorialPlace, arcseconds: float, number: int) -> EquatorialPlace:
    """Give a place beside ``middle``, so far off at the most (″); another for each number."""
    far = arcseconds / 3600.0 * math.sqrt(number * _GOLDEN_SHARE % 1.0)
    turned = math.radians(number * _GOLDEN_ANGLE)
    dec = min(90.0, max(-90.0, middle[1] + far * math.sin(turned)))
    shrink = max(math.cos(math.radians(dec)), 1e-3)
    return (middle[0] + far * math.cos(turned) / shrink / 15.0) % 24.0, dec
