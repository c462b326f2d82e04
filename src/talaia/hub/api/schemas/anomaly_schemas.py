"""What the routes of anomaly detectors take and give."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, Field, StringConstraints

from talaia.hub.api.schemas.common import Schema

__all__ = [
    "AnomalyList",
    "AnomalyShape",
    "ForgiveAnswer",
    "ForgiveAsk",
    "LearnAnswer",
    "LearnAsk",
    "ShareShape",
]


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
