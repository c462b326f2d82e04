"""Missions and their runs, as pages and scripts see them."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from talaia.hub.api.schemas.common import Schema
from talaia.model.missions.mission import StepKind  # noqa: TC001 - pydantic reads it

__all__ = [
    "MissionAsk",
    "MissionList",
    "MissionReading",
    "MissionRow",
    "MissionRunList",
    "MissionRunShape",
    "MissionSaved",
    "MissionScheduleShape",
    "MissionShape",
    "MissionStartAsk",
    "MissionStepRow",
    "MissionStepShape",
    "MissionText",
    "RunActAsk",
]

_Text = Annotated[str, Field(max_length=1000)]
_Name = Annotated[str, Field(max_length=200)]


class MissionStepShape(Schema):
    """One step. ``seconds``: of a pause; else for so long at the most, 0 for an hour.

    ``units``: in which the arguments were written; a step whose units are others by then is
    refused. ``goes_on``: the next one is begun although this was refused or has failed.
    """

    kind: StepKind
    name: _Name
    device: _Name
    command: _Name
    args: Annotated[dict[str, bool | int | float | _Text], Field(max_length=100)]
    units: Annotated[dict[str, _Name], Field(max_length=100)]
    condition: _Text
    seconds: float
    goes_on: bool


class MissionScheduleShape(Schema):
    """When it begins by itself, in the site's time: ``HH:MM``, on days of the week or on a date."""

    at: Annotated[str, Field(max_length=5)]
    days: Annotated[list[Annotated[str, Field(max_length=3)]], Field(max_length=7)]
    date: Annotated[str, Field(max_length=10)]


class MissionShape(Schema):
    """A mission."""

    name: _Name
    note: _Text
    steps: Annotated[list[MissionStepShape], Field(max_length=100)]
    schedule: MissionScheduleShape | None


class MissionRow(Schema):
    """A mission that is kept. ``owner``: saved it last, and its schedule has their rights.

    ``due_us``: when it begins by itself next (UTC); 0: never. ``problem``: why it could not be
    begun now with your rights; empty where it could.
    """

    id: str
    mission: MissionShape
    owner: str
    due_us: int
    changed_us: int
    problem: str


class MissionStepRow(Schema):
    """What became of a step: ``waiting``, ``running``, ``skipped``, or how it ended."""

    name: str
    state: str
    message: str
    began_us: int
    ended_us: int


class MissionRunShape(Schema):
    """One run. ``who``: whose rights it has; ``begun_by``: a person, or ``schedule``.

    ``state``: ``running``, ``paused``, ``succeeded``, ``failed``, ``stopped`` (by STOP),
    ``cancelled``, ``interrupted`` (nobody knows what the robot did) or ``missed``.
    """

    id: str
    mission: str
    name: str
    who: str
    begun_by: str
    state: str
    why: str
    began_us: int
    ended_us: int
    steps: list[MissionStepRow]


class MissionList(Schema):
    """The missions of a site, and the run that goes on there."""

    missions: list[MissionRow]
    run: MissionRunShape | None


class MissionRunList(Schema):
    """The runs of a site, the newest first."""

    runs: list[MissionRunShape]


class MissionAsk(Schema):
    """A mission to be kept; from now on its schedule has your rights."""

    mission: MissionShape


class MissionSaved(Schema):
    """It is kept under this number."""

    id: str


class MissionStartAsk(Schema):
    """Begin it, at this step (counted from 0)."""

    first: Annotated[int, Field(ge=0, le=99)] = 0


class RunActAsk(Schema):
    """What is to become of the run that goes on."""

    act: Literal["pause", "resume", "cancel"]


class MissionText(Schema):
    """A mission as the text of a file."""

    text: Annotated[str, Field(max_length=131_072)]


class MissionReading(Schema):
    """What a file says: a mission, or what is wrong with it and where."""

    mission: MissionShape | None
    where: str
    problem: str
    remedy: str
