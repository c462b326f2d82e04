"""What the routes of recordings take and give."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, Field, StringConstraints

from talaia.hub.api.shapes import Shape

__all__ = ["RecordAskShape", "RecorderShape", "RecordingListShape", "RecordingShape"]


class RecordAskShape(Shape):
    """Begin or end a recording."""

    on: bool
    why: Annotated[str, StringConstraints(max_length=500, strip_whitespace=True)] = Field(
        "", description="why, for those who look at the list"
    )


class RecordingShape(BaseModel):
    """One recording."""

    id: str
    state: Literal["uploading", "complete", "failed"]
    why: str
    who: str
    note: str = Field(description="what is missing in it, or why it failed")
    begin_us: int
    end_us: int
    size: int = Field(description="bytes")
    have: int = Field(description="bytes that are at the hub")
    messages: int
    topics: list[str]


class RecorderShape(BaseModel):
    """How the gateway's recorder stands."""

    described: bool = Field(description="the site description names topics to record")
    online: bool
    on: bool
    id: str
    why: str
    who: str
    since_us: int
    problem: str = Field(description="why the last one failed; empty if it did not")
    topics: list[str] = Field(description="what would be recorded")
    before_s: float = Field(description="so long before its start a recording begins")
    may_record: bool
    may_delete: bool


class RecordingListShape(BaseModel):
    """A site's recordings, the newest first."""

    zone: str
    recorder: RecorderShape
    recordings: list[RecordingShape]
