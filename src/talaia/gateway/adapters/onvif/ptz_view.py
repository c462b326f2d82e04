"""What is known of a camera's motion: where it looks, whether it moves, and its presets."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.gateway.adapters.json_signals import JsonText

if TYPE_CHECKING:
    from talaia.gateway.adapters.onvif.answers import Preset, PtzStatus

__all__ = ["NEAR", "PTZ_KEY", "PtzView"]

# All signals of a camera share one reading, under this key.
PTZ_KEY = "ptz"
# Two places that differ by no more are one (of -1 to 1): cameras round.
NEAR = 0.02
# Between two looks, a camera that rests shows less than this.
_STILL = 0.002


class PtzView:
    """The newest of it. Pure.

    Attributes:
        status: as the camera says it.
        presets: the same.
        moving: whether it moves: as it says, and in any case while the place that it tells
            changes; none where neither is known.

    """

    def __init__(self) -> None:
        """Know nothing."""
        self.status: PtzStatus | None = None
        self.presets: list[Preset] | None = None
        self.moving: bool | None = None

    def see_status(self, status: PtzStatus) -> None:
        """Take in how it stands now."""
        before, self.status = self.status, status
        moved = math.nan if before is None else status.place.distance_to(before.place)
        if status.moving or moved > _STILL:
            self.moving = True
        elif status.moving is False or not math.isnan(moved):
            self.moving = False
        else:
            self.moving = None

    def find_preset(self, wanted: str) -> Preset | str:
        """Find a preset by its name, or else by its token; a text says why there is none."""
        presets = self.presets or []
        named = [preset for preset in presets if preset.name == wanted]
        if len(named) > 1:
            return f"{len(named)} presets are called {wanted!r}; say the token of one"
        if not named:
            named = [preset for preset in presets if preset.token == wanted]
        return named[0] if named else f"the camera has no preset {wanted!r}"

    def payload(self) -> JsonText:
        """Give all of it by the words of `PTZ_VALUES`; null is what is not known."""
        values: dict[str, object] = {
            key: None if math.isnan(value) else value
            for key, value in (
                self.status.place._asdict() if self.status is not None else {}
            ).items()
        }
        values = {"pan": None, "tilt": None, "zoom": None} | values
        values["moving"] = None if self.moving is None else float(self.moving)
        # Of two that are called alike each is shown by its token, by which it can be asked for.
        names = [preset.name for preset in self.presets or []]
        values["presets"] = (
            None
            if self.presets is None
            else "\n".join(
                preset.name if names.count(preset.name) == 1 else preset.token
                for preset in self.presets
            )
        )
        return JsonText("", values, is_json=True)
