"""What the routes of alert rules take and give. Times in ``_us`` are µs (UTC)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, StringConstraints

from talaia.hub.api.schemas.common import Schema
from talaia.hub.api.schemas.observing_schemas import (
    ConfigurationShape,
    ConstraintsShape,
)

__all__ = [
    "AlertAnswer",
    "AlertFilterShape",
    "AlertNoticeAsk",
    "AlertOutcomeShape",
    "AlertPreview",
    "AlertPreviewLine",
    "AlertRuleAsk",
    "AlertRuleList",
    "AlertRuleShape",
]

_Pattern = Annotated[str, StringConstraints(min_length=1, max_length=200, pattern=r"^[^\x00]*$")]
_Name = Annotated[str, StringConstraints(min_length=1, max_length=100, pattern=r"^[^\x00]*$")]
_Number = Annotated[float, Field(ge=-1e300, le=1e300)]
_Patterns = Annotated[list[_Pattern], Field(min_length=1, max_length=50)]
_Limits = Annotated[dict[_Pattern, _Number], Field(max_length=50)]


class AlertFilterShape(Schema):
    """What a notice must be.

    ``sources``: patterns such as ``*SWIFT*``, any of which must fit (none: all);
    ``largest_error`` in ° (0: any place will do); ``least``, ``most`` and ``equal`` by the name of
    a parameter.
    """

    sources: list[_Pattern] = Field(default=[], max_length=50)
    roles: list[Literal["observation", "prediction", "utility", "test"]] = Field(
        default=["observation"], min_length=1, max_length=4
    )
    largest_error: float = Field(default=0.0, ge=0, le=180)
    lowest_declination: float = Field(default=-90.0, ge=-90, le=90)
    highest_declination: float = Field(default=90.0, ge=-90, le=90)
    least: _Limits = Field(default={})
    most: _Limits = Field(default={})
    equal: dict[_Pattern, _Patterns] = Field(default={}, max_length=50)


class AlertRuleAsk(Schema):
    """A rapid request for each event whose notice passes, within ``hours`` of the event."""

    name: _Name
    filter: AlertFilterShape = AlertFilterShape()
    configurations: list[ConfigurationShape] = Field(min_length=1, max_length=100)
    constraints: ConstraintsShape = ConstraintsShape()
    hours: float = Field(default=24.0, gt=0, le=24 * 366)
    priority: float = Field(default=10.0, gt=0, le=1000)
    active: bool = True


class AlertRuleShape(AlertRuleAsk):
    """A rule as it is kept; ``maker`` is the account in whose name it asks (empty: it is gone)."""

    id: str
    maker: str


class AlertRuleList(Schema):
    """The rules of a proposal; ``may_change``: you may add, change and remove them."""

    rules: list[AlertRuleShape]
    may_change: bool


class AlertPreviewLine(Schema):
    """What a rule would have made of a notice, and why."""

    id: str
    event: str
    source: str
    received_us: int
    ra: float | None
    dec: float | None
    passes: bool
    why: str


class AlertPreview(Schema):
    """The newest notices, each event once, with what a rule would have made of them."""

    message: str
    notices: list[AlertPreviewLine]


class AlertNoticeAsk(Schema):
    """A notice as it came: VOEvent 2.0 (XML), or GCN's unified schema (JSON)."""

    text: Annotated[str, StringConstraints(min_length=1, max_length=1024 * 1024)]


class AlertOutcomeShape(Schema):
    """What a rule made of a notice; an empty ``group``: it asked for nothing."""

    rule: str
    name: str
    proposal: str
    group: str
    why: str


class AlertAnswer(Schema):
    """What became of a notice; ``known``: it had come before, and nothing was done again."""

    id: str
    known: bool
    outcomes: list[AlertOutcomeShape]
    canceled: list[str]
