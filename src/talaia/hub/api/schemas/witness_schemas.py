"""Other hubs whose signed heads are kept here."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from talaia.hub.api.schemas.common import Schema

__all__ = [
    "HeadsAsk",
    "HeadsKept",
    "NewWitnessedHub",
    "WitnessedHubAsk",
    "WitnessedHubList",
    "WitnessedHubShape",
]

_Line = Annotated[str, Field(max_length=1000)]


class WitnessedHubShape(Schema):
    """Another hub that leaves signed heads of its audit log here. Times in µs (UTC), 0: never.

    ``key`` is the short name of its key, empty until its first heads came. ``row`` is the newest
    row that it has named, at ``time_us`` by its own clock. ``problem`` says what does not fit
    together: its log was made anew, or cut off.
    """

    id: str
    name: str
    key: str
    keep_days: int
    created_us: int
    heard_us: int
    heads: int
    row: int
    time_us: int
    problem: str


class WitnessedHubList(Schema):
    """All of them, the newest first."""

    hubs: list[WitnessedHubShape]


class WitnessedHubAsk(Schema):
    """Let another hub leave its heads here; each is kept for so many days."""

    name: str = Field(min_length=1, max_length=100)
    keep_days: int = Field(730, ge=7, le=3660)


class NewWitnessedHub(Schema):
    """The token, shown this once; it goes into the file that the other hub's token_file names."""

    id: str
    token: str


class HeadsAsk(Schema):
    """Leave heads here: the hub's token, its public key, and lines as they are in its file."""

    token: str = Field(min_length=1, max_length=200)
    key: str = Field(pattern=r"^[A-Za-z0-9+/]{43}=$")
    lines: list[_Line] = Field(max_length=500)


class HeadsKept(Schema):
    """They are kept, or were before."""

    kept: int
