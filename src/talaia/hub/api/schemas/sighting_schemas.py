"""What the routes of sightings give."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from talaia.model.detection import Measured, ModelKind  # noqa: TC001 - pydantic reads them

__all__ = [
    "BoneShape",
    "CrossingShape",
    "LabelShape",
    "LaneShape",
    "MarkCountShape",
    "PathPlace",
    "PictureMarkShape",
    "PictureModelShape",
    "PicturePlace",
    "ReviewDay",
    "ReviewDays",
    "SeenAsk",
    "SeenMarks",
    "SeenShape",
    "SightingLabels",
    "SightingList",
    "StayShape",
    "StoryShape",
]


class MarkCountShape(BaseModel):
    """A signal that counts at a zone or a line of a camera."""

    signal: str = Field(description="``device/signal``")
    label: str = Field(description="the class that it counts")
    measure: Measured
    max_age: float = Field(description="older than this it is stale (s)")


class PicturePlace(BaseModel):
    """A place on a picture, by parts of its width and height from the upper left."""

    x: float
    y: float


class PictureMarkShape(BaseModel):
    """A zone or a line on a camera's picture, with the signals that the person may see."""

    id: str
    name: str
    points: list[PicturePlace]
    counts: list[MarkCountShape]


class LaneShape(BaseModel):
    """The lane that a camera sees, and its signals; empty for those that the person may not see."""

    to_picture: list[float] = Field(
        description="row by row, the homography from the floor (x ahead and y left of the vehicle, "
        "m, and 1) to parts of the picture's width and height"
    )
    near: float = Field(description="it is looked for from here (m)")
    far: float = Field(description="to here (m)")
    offset: str = Field(description="signal: the vehicle is so far left of the middle (m)")
    heading: str = Field(description="signal: it is turned so against the lane (rad)")
    width: str = Field(description="signal: so wide is the lane (m)")
    max_age: float = Field(description="older than this they are stale (s)")


class BoneShape(BaseModel):
    """Two points of a thing that are drawn joined, by their numbers."""

    start: int
    end: int


class PictureModelShape(BaseModel):
    """A model of one's own that looks at a camera's pictures and tells no boxes."""

    id: str = Field(description="its name in the site description")
    kind: ModelKind
    classes: list[str]
    points: list[str] = Field(description="of keypoints, in the order in which they are told")
    bones: list[BoneShape] = Field(description="of keypoints: which points are drawn joined")
    confidence: float = Field(description="what is less sure is not drawn, 0 to 1")
    max_rate: float = Field(description="pictures a second that are looked at, at the most (Hz)")
    zones: list[PictureMarkShape]


class StayShape(BaseModel):
    """That it was in a zone of the picture."""

    zone: str = Field(description="what the zone is called")
    entries: int = Field(description="how often it came in")
    dwell_s: float = Field(description="how long it was there in all (s)")


class CrossingShape(BaseModel):
    """That it crossed a line on the picture."""

    line: str = Field(description="what the line is called")
    left: int
    right: int


class PathPlace(BaseModel):
    """Where it stood, by parts of the picture's width and height from the upper left."""

    time_us: int
    x: float
    y: float


class StoryShape(BaseModel):
    """What it did while it was in sight."""

    path: list[PathPlace]
    stays: list[StayShape]
    crossings: list[CrossingShape]
    speed: float | None = Field(description="mean on the floor (m/s); null where unknown")


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
    seen: bool = Field(default=False, description="whether the person has looked at it")
    story: StoryShape | None = Field(
        description="what it did; null of what was seen before things were followed"
    )


class SeenAsk(BaseModel):
    """Mark sightings as looked at, or as not, for the person who asks."""

    # As `common.Schema`, whose module imports this one.
    model_config = ConfigDict(extra="forbid", frozen=True)

    ids: list[Annotated[str, Field(pattern=r"^\d{1,18}$")]] = Field(min_length=1, max_length=500)
    seen: bool = True


class SeenMarks(BaseModel):
    """The sightings that were marked: those of the ones asked for whose camera may be seen."""

    ids: list[str]


class ReviewDay(BaseModel):
    """What a camera saw on a day."""

    day: str = Field(description="in the site's time zone, ``2026-11-26``")
    camera: str
    count: int
    unseen: int = Field(description="how many of them the person has not looked at")


class ReviewDays(BaseModel):
    """The newest day first, and cameras by their addresses."""

    days: list[ReviewDay]


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
