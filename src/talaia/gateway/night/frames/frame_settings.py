"""What is set before a frame: filter, binning, gain; each only where it is not so already. Pure."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.gateway.night.step_runner import NightStep

if TYPE_CHECKING:
    from talaia.gateway.night.night_values import NightView
    from talaia.model.night_frames import FrameCommand, SettingCommand
    from talaia.model.night_section import NightSection
    from talaia.model.observing.requests import Configuration

__all__ = ["FrameSettings"]

# Of a reading beside what was asked for.
_NEAR = 1e-3


class FrameSettings:
    """Those of one block.

    Attributes:
        filter: which is in, as far as this block knows; none: nobody has said.

    """

    def __init__(self, night: NightSection) -> None:
        """Begin with nothing known."""
        self._night = night
        self.filter: str | None = None
        # Of those that no signal tells: what was set last, by ``binning`` and ``gain``.
        self._set: dict[str, float] = {}

    def steps_for(self, configuration: Configuration, frame: FrameCommand) -> list[NightStep]:
        """Give what has to be done before a frame that ``frame`` takes."""
        night = self._night
        steps = self._filter_steps(configuration.filter)
        # What the frame's own command takes is said with it.
        if not frame.binning and night.binning is not None:
            binning = float(configuration.binning)
            steps += self._setting_steps("binning", night.binning, binning)
        if not frame.gain and night.gain is not None and configuration.gain is not None:
            steps += self._setting_steps("gain", night.gain, configuration.gain)
        return steps

    def _filter_steps(self, name: str) -> list[NightStep]:
        rule = self._night.filter
        if rule is None or not name or name == self.filter:
            return []

        def chosen() -> None:
            self.filter = name

        return [
            NightStep(
                words=f"changing to filter {name}",
                command=rule.command,
                args={rule.argument: rule.filters[name]},
                within=max(60.0, 3 * self._night.times.filter_change),
                tries=self._night.step_tries,
                on_done=chosen,
            )
        ]

    def _setting_steps(self, key: str, rule: SettingCommand, value: float) -> list[NightStep]:
        if not rule.reading and self._set.get(key) == value:
            return []

        def is_set(view: NightView) -> bool:
            reading = view.binning if key == "binning" else view.gain
            return reading is not None and math.isclose(
                reading, value, rel_tol=_NEAR, abs_tol=_NEAR
            )

        def keep_value() -> None:
            self._set[key] = value

        return [
            NightStep(
                words=f"setting {key} {value:g}",
                command=rule.command,
                args=dict.fromkeys(rule.arguments, value),
                within=rule.within,
                tries=self._night.step_tries,
                reached=is_set if rule.reading else None,
                on_done=keep_value,
            )
        ]
