"""What the routes of sightings give."""

from __future__ import annotations

from pydantic import BaseModel, Field

__all__ = ["LabelShape", "SeenShape", "SightingLabels", "SightingList"]


class SeenShape(BaseModel):
    """Something that a camera saw."""

    id: str
    camera: str = Field(description="the stream, ``device/stream``")
    label: str = Field(description="what was seen, by the detector's name for it")
    many: int = Field(description="how many at once, at the most")
    confidence: float = Field(description="of the surest, 0 to 1")
    began_us: int
    ended_us: int | None = Field(description="when it was seen last; null while it is in sight")
    picture: bool = Field(description="whether there is a picture of a moment of it")


class SightingList(BaseModel):
    """The last to begin first. ``more``: earlier ones of the window were left out."""

    sightings: list[SeenShape]
    more: bool


class LabelShape(BaseModel):
    """A class of which a camera has seen something that is kept."""

    camera: str
    label: str


class SightingLabels(BaseModel):
    """What may be asked for, in the order of the cameras' addresses."""

    labels: list[LabelShape]
