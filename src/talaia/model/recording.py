"""What is recorded of the robot's own messages and of cameras, and what begins it."""

from __future__ import annotations

from enum import StrEnum

from talaia.model.base import Shape

__all__ = ["Recording", "Trigger"]


class Trigger(StrEnum):
    """What begins a recording by itself."""

    STOP = "stop"
    INTERLOCK = "interlock"
    LINK_LOST = "link_lost"
    ALARM = "alarm"


class Recording(Shape, frozen=True, kw_only=True):
    """Raw topics as MCAP files and cameras as films, on demand and around what happens.

    Attributes:
        topics: absolute names; none takes the topics of all signals (cameras are named here).
        cameras: filmed with each recording (``device/stream``), as are those whose topic is
            recorded; others can be filmed on demand.
        before: the last so many seconds are held in memory, and begin each recording (s).
        after: a recording that began by itself goes on for so long after the last cause (s).
        longest: one that was asked for ends by itself after so long (s).
        triggers: what begins one by itself.
        ring_mb: what is held in memory takes no more than this (MB), and films as much again;
            the oldest gives way.
        file_mb: a recording ends when it is so large (MB); a film goes on in another file.
        disk_mb: recordings that wait for the hub take no more than this (MB), and films as much
            again; the oldest go.
        upload: they are sent to the hub at no more than this (kB/s), behind everything else.

    """

    topics: tuple[str, ...] = ()
    cameras: tuple[str, ...] = ()
    before: float = 30.0
    after: float = 30.0
    longest: float = 600.0
    triggers: tuple[Trigger, ...] = (
        Trigger.STOP,
        Trigger.INTERLOCK,
        Trigger.LINK_LOST,
        Trigger.ALARM,
    )
    ring_mb: float = 64.0
    file_mb: float = 500.0
    disk_mb: float = 2000.0
    upload: float = 500.0
