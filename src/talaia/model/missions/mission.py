"""A mission as a value: steps in order, and when they are done by themselves.

The same shape stands in a file of its own and in the hub's database.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TypeAlias

from talaia.model.base import Shape

__all__ = [
    "DAYS",
    "LONGEST_S",
    "MOST_STEPS",
    "Mission",
    "MissionArgument",
    "MissionSchedule",
    "MissionStep",
    "StepKind",
]

MOST_STEPS = 100
# Of one step.
LONGEST_S = 86_400.0
# As they are written, the first of a week first.
DAYS = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")

MissionArgument: TypeAlias = bool | int | float | str


class StepKind(StrEnum):
    """What a step does."""

    # A command of the description: a goal, a service, a parameter.
    COMMAND = "command"
    # Waits until a condition holds.
    UNTIL = "until"
    # Waits for a time.
    PAUSE = "pause"


class MissionStep(Shape, frozen=True, kw_only=True):
    """One step.

    Attributes:
        kind: what it does.
        name: what people call it; what it does gives the name where this is left out.
        device: command: of which device.
        command: command: which of its commands.
        args: command: its arguments by name.
        units: command: the units that they were written in; another than the description has when
            the step begins is refused.
        condition: until: what has to hold, written as an alarm's expression; what is unknown or
            too old does not.
        seconds: pause: for how long. The others: for so long at the most, 0 for an hour.
        goes_on: the next step is begun although this one was refused or has failed.

    """

    kind: StepKind
    name: str = ""
    device: str = ""
    command: str = ""
    args: dict[str, MissionArgument] = {}
    units: dict[str, str] = {}
    condition: str = ""
    seconds: float = 0.0
    goes_on: bool = False


class MissionSchedule(Shape, frozen=True, kw_only=True):
    """When a mission begins by itself, in the site's own time.

    Attributes:
        at: the time of day, ``HH:MM``.
        days: on these days of the week, ``mon`` to ``sun``; every day where there is neither this
            nor a date.
        date: once, on this day, ``YYYY-MM-DD``.

    """

    at: str
    days: tuple[str, ...] = ()
    date: str = ""


class Mission(Shape, frozen=True, kw_only=True):
    """A mission of one site.

    Attributes:
        name: what people call it.
        note: what it is for, in a sentence.
        steps: done one after the other.
        schedule: when it begins by itself; never where this is left out.

    """

    name: str
    note: str = ""
    steps: tuple[MissionStep, ...] = ()
    schedule: MissionSchedule | None = None
