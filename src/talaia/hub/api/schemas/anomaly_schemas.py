"""What the routes of anomaly detectors take and give."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, Field, StringConstraints

from talaia.hub.api.schemas.common import Schema
from talaia.model.ai_services import MOST_A_WEEK

__all__ = [
    "AnomalyList",
    "AnomalyShape",
    "BackTestAsk",
    "BackTestShape",
    "BudgetAsk",
    "BudgetShape",
    "ConfirmAsk",
    "ForgiveAnswer",
    "ForgiveAsk",
    "LearnAnswer",
    "LearnAsk",
    "PastAnomalyShape",
    "ShareShape",
]

_TIME = Annotated[int, Field(ge=0, le=2**62)]


class ShareShape(BaseModel):
    """What one signal of a group has to do with an anomaly."""

    signal: str = Field(description="its address")
    share: float = Field(description="of the squared distance from what is usual, 0 to 1")
    spreads: float = Field(description="usual spreads above (negative: below) its usual level")


class AnomalyShape(BaseModel):
    """One detector at work on a signal, or on a group of signals."""

    address: str = Field(description="of the signal: ``device/signal``; of a group: ``/name``")
    detector: str = Field(description="its word in the site description")
    name: str = Field(description="as people call it")
    bar: float = Field(description="a score from here on is an anomaly")
    score: float = Field(description="the newest, 0 to 1")
    scores: str = Field(description="the channel of the history that holds its scores")
    began_us: int = Field(description="since when an anomaly is on; -1 while there is none")
    from_us: int = Field(description="when the newest anomaly began; 0 before the first")
    to_us: int = Field(description="its last high sample; 0 while it is on")
    why: str = Field(description="of the anomaly that is on, or of the last one")
    forgiven: bool = Field(description="whether a person said that it was none")
    confirmed: bool = Field(description="whether a person said that it was one")
    learns: bool = Field(description="whether it can be told so: limits are changed by hand")
    learning: int = Field(
        description="so many samples until it has learned; before, it tells little"
    )
    late: int = Field(description="samples that came after newer ones and were not looked at")
    title: str = Field(description="of a group: what people call it; empty for a signal")
    signals: list[str] = Field(description="of a group: the addresses of its signals")
    step_s: float = Field(description="of a group: its signals are looked at so often; 0: no group")
    mode: str = Field(description="of a group: the way of running it is in, if it has several")
    shares: list[ShareShape] = Field(
        description="of a group: which signals made the newest anomaly so, greatest first"
    )


class AnomalyList(BaseModel):
    """All detectors of a site that the person may see."""

    detectors: list[AnomalyShape]
    may_forgive: bool = Field(description="whether the person may say that one was no anomaly")
    skipped: int = Field(description="samples that the hub had no time for, since its start")


class ForgiveAsk(Schema):
    """Say that the latest peak of a detector's score was no anomaly."""

    address: Annotated[str, StringConstraints(max_length=200)]
    detector: Annotated[str, StringConstraints(max_length=20)]
    comment: Annotated[str, StringConstraints(max_length=500, strip_whitespace=True)] = ""


class ConfirmAsk(Schema):
    """Say that the newest anomaly of a detector was real: it counts as no false alarm."""

    address: Annotated[str, StringConstraints(max_length=200)]
    detector: Annotated[str, StringConstraints(max_length=20)]
    comment: Annotated[str, StringConstraints(max_length=500, strip_whitespace=True)] = ""


class BudgetAsk(Schema):
    """Say how many false alarms a week are borne."""

    a_week: Annotated[float, Field(ge=0, le=MOST_A_WEEK)] | None = Field(
        description="0: detectors' own bars hold; null: as the description says"
    )


class BudgetShape(BaseModel):
    """How often the detectors of a site may cry, and what their thresholds stand on."""

    a_week: float = Field(description="false alarms a week that are borne; 0: nobody asked")
    described: float = Field(description="what the description says; 0: nothing")
    by_person: bool = Field(description="whether a person said another number than it")
    basis: Literal["learning", "short", "counted"] = Field(
        description="``learning``: own bars hold as less than a day was seen; ``short``: carried on"
        " from the greatest scores; ``counted``: as many were above it as are borne"
    )
    seen_s: float = Field(description="so much of the past was looked at (s)")
    needed_s: float = Field(description="from so much on false alarms are counted (s)")
    reading: int = Field(description="detectors whose stored history is still to be looked at")
    kept: int = Field(description="detectors that the budget holds for")
    others: int = Field(description="detectors whose own bars hold: limits, silence and the like")
    may_change: bool = Field(description="whether the person may say another number")


class ForgiveAnswer(BaseModel):
    """What the detector made of it."""

    learned: bool = Field(description="false where it cannot: limits are changed by hand")


class LearnAsk(Schema):
    """Say that a stretch of the history shows a group of signals as it usually is."""

    address: Annotated[str, StringConstraints(max_length=200)] = Field(description="of the group")
    from_us: int = Field(description="where the stretch begins (µs, UTC)")
    to_us: int = Field(description="where it ends (µs, UTC)")
    comment: Annotated[str, StringConstraints(max_length=500, strip_whitespace=True)] = ""


class LearnAnswer(BaseModel):
    """What the group learned from a stretch."""

    rows: int = Field(description="steps in which there was any of its signals")
    modes: list[str] = Field(
        description="ways of running that it has learned; empty where it has one"
    )
    still: list[str] = Field(
        description="of a group by states: those of which the stretch held too little"
    )


class BackTestAsk(Schema):
    """Try a detector on stored history."""

    address: Annotated[str, StringConstraints(max_length=200)] = Field(
        description="of the signal: ``device/signal``; of a group that is described: ``/name``"
    )
    detector: Annotated[str, StringConstraints(max_length=20)] = Field(
        default="group", description="as in the site description; ``group`` for a group"
    )
    from_us: _TIME = Field(description="where the window begins (µs, UTC)")
    to_us: _TIME = Field(description="where it ends (µs, UTC)")
    bar: Annotated[float, Field(ge=0, le=1)] = Field(
        default=0.0, description="a score from here on is an anomaly; 0: the detector's own"
    )
    learn: Annotated[int, Field(ge=0, le=30_000)] = Field(
        default=0, description="of a group: it learns from so many steps; 0: as it is described"
    )
    minimum: float | None = Field(default=None, description="of ``limits``")
    maximum: float | None = Field(default=None, description="of ``limits``")


class PastAnomalyShape(BaseModel):
    """An anomaly that would have been told."""

    from_us: int = Field(description="when it would have begun (µs, UTC)")
    to_us: int = Field(description="its last high score (µs, UTC)")
    score: float = Field(description="its greatest")
    why: str = Field(description="in words")
    shares: list[ShareShape] = Field(description="of a group: which signals made it so")


class BackTestShape(BaseModel):
    """How a test stands, and what it found up to now."""

    key: str = Field(description="by which it is asked for")
    address: str = Field(description="of the signal or the group")
    detector: str = Field(description="what is tried")
    bar: float = Field(description="a score from here on is an anomaly")
    from_us: int = Field(description="where its window begins (µs, UTC)")
    to_us: int = Field(description="where it ends (µs, UTC)")
    state: Literal["running", "done", "cancelled", "failed"]
    problem: str = Field(description="why it failed; else empty")
    progress: float = Field(description="how much of it is done, 0 to 1")
    rows: int = Field(description="steps of the window that it has looked at")
    cpu_s: float = Field(description="what it has cost: seconds of a core")
    count: int = Field(description="anomalies that would have been told")
    anomalies: list[PastAnomalyShape] = Field(description="the first 200 of them")
    scores: list[float] = Field(
        description="the greatest score of each part of the window, all parts alike; -1: none"
    )
    learning: int = Field(
        description="samples it had still to learn from when the window began; more than 0: there"
        " was too little history before it"
    )
