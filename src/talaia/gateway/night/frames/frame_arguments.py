"""What a camera's command is asked with for a frame. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.night_frames import FrameCommand
    from talaia.wire.frames import Scalar

__all__ = ["frame_arguments"]


def frame_arguments(
    rule: FrameCommand, exposure: float, *, target: str = "", binning: int = 1, gain: float | None
) -> Mapping[str, Scalar]:
    """Give a frame's arguments, by name."""
    args: dict[str, Scalar] = dict(rule.args)
    if rule.seconds:
        args[rule.seconds] = exposure
    if rule.target and target:
        args[rule.target] = target[:60]
    if rule.binning:
        args[rule.binning] = binning
    if rule.gain and gain is not None:
        args[rule.gain] = gain
    return args
