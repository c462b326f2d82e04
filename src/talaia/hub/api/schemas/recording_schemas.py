"""What the routes of recordings take and give."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, Field, StringConstraints

from talaia.hub.api.schemas.common import Schema
from talaia.hub.store.sites.recordings import RecordingState  # noqa: TC001 - pydantic reads it

__all__ = [
    "FilmListShape",
    "FilmShape",
    "RecordAskShape",
    "RecorderShape",
    "RecordingListShape",
    "RecordingShape",
    "UnfilmedShape",
]


class RecordAskShape(Schema):
    """Begin or end a recording."""

    on: bool
    why: Annotated[str, StringConstraints(max_length=500, strip_whitespace=True)] = Field(
        "", description="why, for those who look at the list"
    )
    stream: Annotated[str, StringConstraints(max_length=200)] = Field(
        "", description="film only this camera (`device/stream`)"
    )


class RecordingShape(BaseModel):
    """One recording."""

    id: str
    state: RecordingState
    why: str
    who: str
    note: str = Field(description="what is missing in it, or why it failed")
    begin_us: int
    end_us: int
    size: int = Field(description="bytes")
    have: int = Field(description="bytes that are at the hub")
    messages: int = Field(description="of a film its pictures")
    topics: list[str]
    stream: str = Field(description="the camera that it is a film of; empty: raw topics")


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
    cameras: list[str] = Field(description="which would be filmed with it")
    filming: list[str] = Field(description="cameras that are being filmed now")
    can_film: bool = Field(description="its gateway can film cameras")
    before_s: float = Field(description="so long before its start a recording begins")
    may_record: bool
    may_delete: bool


class RecordingListShape(BaseModel):
    """A site's recordings, the newest first."""

    zone: str
    recorder: RecorderShape
    recordings: list[RecordingShape]


class FilmShape(BaseModel):
    """One film of a camera. A picture's time is `begin_us` and its time in the file."""

    id: str
    stream: str
    state: RecordingState
    why: str
    who: str
    note: str = Field(description="what is missing in it, or why it failed")
    begin_us: int = Field(description="when its first picture came to the gateway")
    end_us: int = Field(description="when its last one did")
    size: int = Field(description="bytes")
    have: int = Field(description="bytes that are at the hub")
    pictures: int


class UnfilmedShape(BaseModel):
    """A recording that has a camera's pictures as messages, and beside which there is no film."""

    recording: str
    stream: str
    begin_us: int
    end_us: int


class FilmListShape(BaseModel):
    """The films of the cameras that you may see, the newest first."""

    films: list[FilmShape]
    more: bool = Field(description="there are older ones in this time, which are left out")
    unfilmed: list[UnfilmedShape]
    filming: list[str] = Field(description="cameras that are being filmed now")
    may_film: bool = Field(description="you may begin a film, and the gateway can make one now")
    why_not: str = Field(description="why no film can be begun; empty where one can")
