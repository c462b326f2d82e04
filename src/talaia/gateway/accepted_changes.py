"""How far a hub may change the description; read with a gateway's words, before the model is."""

from __future__ import annotations

from enum import StrEnum

__all__ = ["AcceptedChanges"]


class AcceptedChanges(StrEnum):
    """How far the hub may change the description."""

    # Not at all.
    NO = "no"
    # What is read and shown: signals and streams that nothing else depends on, names, limits.
    READINGS = "readings"
    # Also what can be done: commands, driving, interlocks. Never what runs beside the robot.
    ALL = "all"
