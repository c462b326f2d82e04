"""What the routes of causes take and give."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, Field, StringConstraints

# pydantic reads it at run time.
from talaia.hub.api.schemas.anomaly_schemas import ShareShape  # noqa: TC001
from talaia.hub.api.schemas.common import Schema

__all__ = ["CauseShape", "KnownAsk", "KnownShape", "SimilarShape", "StateShape", "UnusualShape"]

_Word = Annotated[str, StringConstraints(max_length=200)]


class UnusualShape(BaseModel):
    """What one detector said within the minute."""

    address: str = Field(description="of the signal: ``device/signal``; of a group: ``/name``")
    detector: str = Field(description="its word in the site description")
    title: str = Field(description="what people call what it looks at")
    score: float = Field(description="its greatest score there")
    bar: float = Field(description="a score from here on is an anomaly")
    at_us: int = Field(description="when that was (µs, UTC)")
    newest: bool = Field(description="its newest anomaly was then: what a person says is of that")
    shares: list[ShareShape] = Field(
        description="of a group whose newest anomaly was then: which signals made it so"
    )


class SimilarShape(BaseModel):
    """The last episode like this one, and what a person said of it."""

    began_us: int = Field(description="when it began (µs, UTC)")
    names: list[str] = Field(description="what was unusual then")
    likeness: float = Field(description="what both have in common of what either had, 0 to 1")
    verdict: str = Field(
        description="``confirmed``, ``forgiven`` or ``known``; empty: nobody said anything"
    )
    comment: str = Field(description="in words, with what it was on")
    who: str = Field(description="said it")


class StateShape(BaseModel):
    """A state that the machine was in."""

    address: str = Field(description="of the state signal")
    title: str = Field(description="what people call it")
    value: int = Field(description="the state's place among its names")
    name: str = Field(description="the state's name")


class KnownShape(BaseModel):
    """What people know and are not told of."""

    key: str = Field(description="by which it is ended")
    address: str = Field(description="of the signal or the group")
    detector: str = Field(description="its word in the site description")
    title: str = Field(description="what people call what it looks at")
    state: str = Field(description="address of the state while which it holds; empty: always")
    state_name: str = Field(description="in words: ``Mode docked``")
    who: str = Field(description="said it")
    comment: str = Field(description="why")
    since_us: int = Field(description="since when (µs, UTC)")
    holds: bool = Field(description="whether the machine is in that state now")


class CauseShape(BaseModel):
    """What was unusual within a minute of a moment, ranked; and when it was like that before."""

    at_us: int
    from_us: int
    to_us: int
    unusual: list[UnusualShape] = Field(description="the most unusual first")
    similar: SimilarShape | None
    states: list[StateShape] = Field(description="the states of the site at that moment")
    known: list[KnownShape] = Field(description="what nobody is told of")
    may_use: bool = Field(description="whether the person may say something of it")


class KnownAsk(Schema):
    """Say that a detector's anomalies are known while the machine is in a state."""

    address: _Word
    detector: Annotated[str, StringConstraints(max_length=20)]
    state: _Word = Field(default="", description="address of the state; empty: at all times")
    value: Annotated[int, Field(ge=0, le=10_000)] = 0
    comment: Annotated[str, StringConstraints(max_length=500, strip_whitespace=True)] = ""
