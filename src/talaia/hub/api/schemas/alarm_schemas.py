"""What the routes of alarms take and give. Times ending in ``_us`` are µs since the epoch (UTC)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, StringConstraints

from talaia.hub.alarms.preview import Span  # noqa: TC001 - pydantic reads it
from talaia.hub.api.schemas.common import Schema
from talaia.model.alarms.alarm import AlarmKind, Severity

__all__ = [
    "ActAsk",
    "AlarmDefinition",
    "AlarmList",
    "AlarmPast",
    "AlarmPastList",
    "AlarmShape",
    "EscalationShape",
    "PreviewAsk",
    "PreviewShape",
]

_Name = Annotated[str, StringConstraints(max_length=200, pattern=r"^[^\x00]*$")]
_Words = Annotated[str, StringConstraints(max_length=1000, pattern=r"^[^\x00]*$")]
# No limit can be held against NaN, and JSON cannot say it.
_Number = Annotated[float, Field(allow_inf_nan=False)]


class EscalationShape(Schema):
    """Who is told of an alarm that nobody has acknowledged, and how long after it was raised."""

    who: _Name
    after: _Number = 0.0


class AlarmDefinition(Schema):
    """An alarm, in the words of the site description; see there what each key means."""

    name: _Name
    kind: AlarmKind
    signal: _Name = ""
    device: _Name = ""
    inside: _Name = ""
    outside: _Name = ""
    margin: _Number = 0.0
    above: _Number | None = None
    below: _Number | None = None
    hysteresis: _Number = 0.0
    # ``is`` in the description.
    is_one_of: list[_Name] = Field(default=[], max_length=100)
    is_not: list[_Name] = Field(default=[], max_length=100)
    max_age: _Number | None = None
    score: _Number = 0.0
    stream: _Name = ""
    label: _Name = ""
    count: int = Field(default=1, ge=1, le=1000)
    confidence: _Number = 0.5
    expression: _Words = ""
    enclosure: _Name = ""
    severity: Severity = Severity.WARNING
    delay: _Number = 0.0
    clear_delay: _Number = 0.0
    unknown_after: _Number | None = None
    repeat: _Number | None = None
    remind: _Number | None = None
    escalate: list[EscalationShape] = Field(default=[], max_length=50)
    record: bool = False
    advice: _Words = ""


class AlarmShape(Schema):
    """An alarm that is open to you.

    ``definition`` is what it watches; ``made``: in the page, where it can be changed too;
    ``problem``: why it does not fit the description; ``may_use``: you may acknowledge it.
    """

    alarm: str
    device: str
    definition: AlarmDefinition
    made: bool
    problem: str
    may_use: bool


class AlarmList(Schema):
    """The alarms of a site. ``may_manage``: you may make, change and remove them."""

    alarms: list[AlarmShape]
    may_manage: bool


class ActAsk(Schema):
    """Do something about an alarm.

    ``text`` is the comment or the reason; ``to`` whom it is assigned to (empty: nobody);
    ``until_us`` the end of the shelving.
    """

    act: Literal["acknowledge", "assign", "comment", "shelve", "unshelve"]
    text: Annotated[_Words, StringConstraints(strip_whitespace=True)] = ""
    to: _Name = ""
    until_us: int = Field(default=0, ge=0, le=2**53)


class AlarmPast(Schema):
    """One thing that happened to an alarm; ``episode`` counts how often it was raised."""

    id: str
    what: str
    episode: int
    time_us: int
    who: str
    message: str


class AlarmPastList(Schema):
    """What happened to an alarm, newest first; with ``more``, ask again ``before`` the last."""

    past: list[AlarmPast]
    more: bool


class PreviewAsk(Schema):
    """How an alarm would have done over a window, by default the last day."""

    definition: AlarmDefinition
    hours: float = Field(default=24, gt=0, le=24 * 31, allow_inf_nan=False)


class PreviewShape(Schema):
    """What would have been.

    ``problem`` says what does not fit, ``where`` the key it is about; then the rest is empty.
    ``now`` is what is so now, in words; ``unknown_us``: for so long it could not be judged.
    """

    where: str = ""
    problem: str = ""
    from_us: int = 0
    to_us: int = 0
    count: int = 0
    unknown_us: int = 0
    spans: list[Span] = Field(default=[])
    signals: list[str] = Field(default=[])
