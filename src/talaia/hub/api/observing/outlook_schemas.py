"""What is said of requests before they are handed in, and of the night. ``_us``: µs (UTC)."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, StringConstraints

from talaia.hub.api.schemas.common import Schema
from talaia.hub.api.schemas.observing_schemas import (
    ConfigurationShape,
    ConstraintsShape,
    GroupAsk,
    PlanShape,
    WhyNotShape,
    WindowShape,
)
from talaia.hub.request_files.readers import FileKind  # noqa: TC001 - pydantic reads it

__all__ = [
    "FileProblemShape",
    "ForecastReason",
    "ForecastShape",
    "ImportAnswer",
    "ImportAsk",
    "RequestChanceShape",
    "RequestOutlookShape",
    "SkyCurveShape",
    "ValidationShape",
    "WeekNightShape",
    "WeekShape",
]


class SkyCurveShape(Schema):
    """A night for a chart: altitudes (°) every ten minutes, and whether all constraints hold."""

    times_us: list[int]
    altitude: list[float]
    sun_altitude: list[float]
    moon_altitude: list[float]
    allowed: list[bool]


class RequestOutlookShape(Schema):
    """When a request can be observed: in ``possible`` of ``nights`` that were looked at.

    ``message`` says it in words; ``curve`` is of the best night. ``tonight`` and ``week`` are the
    chances (0 to 1) that it is observed tonight, and in the nights of the forecast, beside what
    waits already and with a usual share of open time; none: no forecast yet, or no plan holds it.
    """

    charge_s: float
    nights: int
    possible: int
    best_us: int | None
    message: str
    curve: SkyCurveShape | None
    tonight: float | None
    week: float | None


class ValidationShape(Schema):
    """What would become of a group that is handed in as it is.

    ``problems`` keep it from being handed in; what can never be observed is no problem of that
    kind, and said in the outlook. ``requests`` holds the outlooks of the first few. ``left_s`` is
    what the proposal has left, ``person_left_s`` your part of it (none: there are no parts).
    ``forecast_us`` is when the forecast was made that chances go by (none: there is none yet), and
    ``forecast_nights`` how many nights it has.
    """

    problems: list[str]
    charge_s: float
    left_s: float
    person_left_s: float | None
    forecast_us: int | None
    forecast_nights: int
    requests: list[RequestOutlookShape]


class ImportAsk(Schema):
    """Another program's file; the rest stands in where the file says nothing."""

    kind: FileKind
    # Within what a body may hold.
    text: Annotated[str, StringConstraints(max_length=1_000_000, pattern=r"^[^\x00]*$")]
    proposal: Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$")]
    window: WindowShape
    configurations: list[ConfigurationShape] = Field(
        default=[ConfigurationShape(exposure=60.0)], min_length=1, max_length=100
    )
    constraints: ConstraintsShape = ConstraintsShape()


class FileProblemShape(Schema):
    """What of a file could not be read, and where: a line, or a path."""

    where: str
    message: str


class ImportAnswer(Schema):
    """What a file asks, as drafts that are not kept yet, and what of it could not be read."""

    groups: list[GroupAsk]
    problems: list[FileProblemShape]


class ForecastReason(Schema):
    """Why a request that you see is not in the forecast's first place."""

    request: str
    target: str
    why_not: WhyNotShape


class ForecastShape(Schema):
    """The night to come as the planner would have it, with a clear sky, as of ``plan.made_us``.

    ``reasons``: of requests that you see and that are not planned; ``more``: of others, too.
    """

    plan: PlanShape
    reasons: list[ForecastReason]
    more: bool


class RequestChanceShape(Schema):
    """The chance (0 to 1) that a request is observed in one night."""

    request: str
    proposal: str
    target: str
    chance: float


class WeekNightShape(Schema):
    """One night; ``planned``: requests in its plan, of others too, which it shows as such."""

    start_us: int
    end_us: int
    planned: int
    plan: PlanShape
    chances: list[RequestChanceShape]


class WeekShape(Schema):
    """Tonight and six nights more, as of ``made_us``, with a usual share of open time (0 to 1).

    ``renewing``: a newer one is being made.
    """

    made_us: int
    renewing: bool
    open_share: float
    nights: list[WeekNightShape]
