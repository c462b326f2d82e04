"""What the routes of recorded topics give."""

from __future__ import annotations

from pydantic import BaseModel, Field

__all__ = [
    "MomentShape",
    "RecordedMessageShape",
    "RecordedTopicShape",
    "StretchShape",
]


class RecordedTopicShape(BaseModel):
    """A topic that a recording holds, and that you may have."""

    topic: str
    type: str
    latched: bool = Field(description="what it said holds until it says something else")
    problem: str = Field(description="why its messages cannot be read; empty: they can")
    begin_us: int = Field(description="of the recording that holds it")
    end_us: int
    camera: str = Field(
        default="",
        description="of a calibration: the camera (`device/stream`) whose pictures it speaks of, "
        "as the site is described now; empty where you may see none",
    )


class MomentShape(BaseModel):
    """What recordings hold of a moment, by topic."""

    topics: list[RecordedTopicShape]
    earlier_us: int | None = Field(description="end of the nearest recording before the moment")
    later_us: int | None = Field(description="begin of the nearest recording after it")
    problems: list[str] = Field(description="why a recording of the moment cannot be read")


class RecordedMessageShape(BaseModel):
    """A message of a recorded topic, as a tree."""

    topic: str
    time_us: int = Field(description="when it came to the recorder (UTC)")
    publish_us: int = Field(description="when it was published (UTC)")
    size: int = Field(description="bytes as the robot serialized it")
    tree: str = Field(description="as JSON, see `TopicMessage.tree`; empty where it is none")


class StretchShape(BaseModel):
    """Messages of a stretch of time, by time, and the last ones before it."""

    topics: list[RecordedTopicShape] = Field(description="once for each recording that has them")
    messages: list[RecordedMessageShape]
    until_us: int = Field(description="all before this moment is there; ask on from here")
