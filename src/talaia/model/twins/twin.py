"""A digital twin as the description says it."""

from __future__ import annotations

from enum import IntEnum

from talaia.model.base import Shape

__all__ = ["MODES", "Twin", "TwinMode"]


class TwinMode(IntEnum):
    """What a twin does, as it is published on its topic ``mode``.

    ``WAITING``: nothing is heard of the robot. ``FOLLOWING``: it goes where the robot goes.
    ``REHEARSING``: it is driven alone.
    """

    WAITING = 0
    FOLLOWING = 1
    REHEARSING = 2


MODES = tuple(mode.name.lower() for mode in TwinMode)
"""The states that a twin's signal ``mode`` has to name, in order."""


class Twin(Shape, frozen=True, kw_only=True):
    """This device is the simulated twin of another: ``talaia twin`` runs it beside that one.

    Attributes:
        of: the driven device that it is the twin of.
        friction: rolling friction of its wheels (N per m/s); 40 costs about 9 % of the speed.
        track_width: distance between its wheels (m).
        follow_rate: it is moved this share of its error to the robot each second (1/s).
        reset_beyond: farther from the robot than this (m) for ``reset_after``, it is put there.
        reset_turn: the same of its heading (rad).
        reset_after: see there (s).

    """

    of: str
    friction: float = 0.0
    track_width: float = 0.16
    follow_rate: float = 1.0
    reset_beyond: float = 0.5
    reset_turn: float = 0.5
    reset_after: float = 1.0
