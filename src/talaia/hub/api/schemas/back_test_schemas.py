"""What the routes of back-tests take and give."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, Field, StringConstraints

from talaia.hub.api.schemas.anomaly_schemas import ShareShape  # noqa: TC001 - pydantic reads it
from talaia.hub.api.schemas.common import Schema

__all__ = ["BackTestAsk", "BackTestShape", "PastAnomalyShape"]

_TIME = Annotated[int, Field(ge=0, le=2**62)]


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
