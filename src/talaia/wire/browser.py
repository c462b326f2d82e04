"""Every message between hub and browser.

Two sockets: ``/ws`` for all but pictures, and one ``/ws/media?site=…&stream=…`` for each camera
a page shows. MessagePack by default; ``?form=json`` gives the JSON form. The session cookie (or
a token) says who it is; rights are checked on every message, both ways.

Long, because the messages of one socket are read together, in one place.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.wire.frames import MAX_PICTURE, CommandPhase, Count, LeaseOp, Name, Scalar
from talaia.wire.shape import PROTOCOL, Codec, Message

__all__ = [
    "FROM_BROWSER",
    "MEDIA_FROM_BROWSER",
    "MEDIA_TO_BROWSER",
    "TO_BROWSER",
    "Command",
    "CommandNews",
    "Drive",
    "DriveNews",
    "Ended",
    "EventNews",
    "FromBrowser",
    "Greeting",
    "Lease",
    "LeaseNews",
    "Ping",
    "Pong",
    "Problem",
    "Reset",
    "ResetKey",
    "SessionNews",
    "Shot",
    "Shown",
    "SiteNews",
    "Stop",
    "StopNews",
    "Subscribe",
    "Subscribed",
    "TickNews",
    "ToBrowser",
    "Unsubscribe",
    "Values",
]

# ── browser to hub ──────────────────────────────────────────────────────────────────────────


class Subscribe(Message, frozen=True, kw_only=True, tag="subscribe"):
    """Send me these channels of a site, at most every so many ms.

    Attributes:
        sub: the asker's number for this subscription; one that is in use is replaced.
        channels: addresses; `Values.channel` indexes this list.
        every_ms: 0 sends as they come; larger conflates (first, least, greatest and last
            of each channel are kept).

    """

    sub: Annotated[int, Meta(ge=0, le=65_535)]
    site: Name
    channels: Annotated[list[Name], Meta(max_length=10_000)]
    every_ms: Annotated[int, Meta(ge=0, le=60_000)] = 50


class Unsubscribe(Message, frozen=True, kw_only=True, tag="unsubscribe"):
    """No more of this subscription."""

    sub: int


class Lease(Message, frozen=True, kw_only=True, tag="lease"):
    """Take, renew or free the lease of a device."""

    site: Name
    device: Name
    op: LeaseOp


class Drive(Message, frozen=True, kw_only=True, tag="drive"):
    """A driving frame; the fields are those of `frames.Drive`."""

    site: Name
    device: Name
    epoch: Count
    seq: Count
    tick: Count
    held_ms: float = 0.0
    linear: float
    angular: float
    picture_ms: float = -1.0


class Stop(Message, frozen=True, kw_only=True, tag="stop"):
    """STOP (software). Repeat with the same id until `StopNews` with it comes."""

    site: Name
    device: Name
    id: Name


class Reset(Message, frozen=True, kw_only=True, tag="reset"):
    """Release STOP: first without a token, then with the one that `ResetKey` brought."""

    site: Name
    device: Name
    epoch: Count
    token: str = ""


class Command(Message, frozen=True, kw_only=True, tag="command"):
    """Ask a device to do something once. ``id`` is the page's own, never used twice."""

    site: Name
    device: Name
    command: Name
    id: Name
    args: dict[str, Scalar] = {}


class Ping(Message, frozen=True, kw_only=True, tag="ping"):
    """Every second.

    Attributes:
        at_ms: the page's own clock, handed back in `Pong`.
        active: a person has touched the page since the last one; that keeps the session.

    """

    n: Count
    at_ms: float
    active: bool = False


# ── hub to browser ──────────────────────────────────────────────────────────────────────────


class Greeting(Message, frozen=True, kw_only=True, tag="greeting"):
    """First frame: who the hub takes you for."""

    protocol: int = PROTOCOL
    version: str = ""
    who: str
    role: str
    time_us: int


class SiteNews(Message, frozen=True, kw_only=True, tag="site"):
    """A site's link came up or went down, or its description changed (``catalogue``)."""

    site: str
    online: bool
    since_us: int
    catalogue: str = ""
    loop_ms: float = 0.0
    skew_ms: float = 0.0
    why: str = ""


class Subscribed(Message, frozen=True, kw_only=True, tag="subscribed"):
    """Answer to `Subscribe`. Channels you may not see, or that are not there, are refused."""

    sub: int
    refused: list[str] = []


class Values(Message, frozen=True, kw_only=True, tag="values"):
    """Samples of a subscription as columns; see `wire.columns`.

    The first `Values` of a subscription holds the last known sample of each channel;
    ``age_ms`` then tells the age of each by the hub's clock, by position in the batch.
    """

    sub: int
    base_us: int
    channel: bytes
    offset: bytes
    value: bytes
    texts: dict[int, str] = {}
    age_ms: list[float] = []


class LeaseNews(Message, frozen=True, kw_only=True, tag="lease_news"):
    """Who holds a device. ``epoch`` is not 0 only when it is you (``yours``)."""

    site: str
    device: str
    holder: str = ""
    yours: bool = False
    epoch: int = 0
    remains_ms: int = 0
    refused: str = ""


class TickNews(Message, frozen=True, kw_only=True, tag="tick"):
    """The gateway's newest time mark; echo it in `Drive`."""

    site: str
    tick: int


class DriveNews(Message, frozen=True, kw_only=True, tag="drive_news"):
    """What the robot is being told; see `frames.DriveState`."""

    site: str
    device: str
    linear: float
    angular: float
    cap: float
    loop_ms: float = 0.0
    accepted: int = 0
    refused: int = 0
    why: str = ""


class StopNews(Message, frozen=True, kw_only=True, tag="stop_news"):
    """STOP (software): see `frames.StopState`."""

    site: str
    device: str
    latched: bool
    confirmed: bool = False
    who: str = ""
    time_us: int = 0
    id: str = ""


class ResetKey(Message, frozen=True, kw_only=True, tag="reset_key"):
    """The token for the second step of a reset, or why there is none."""

    site: str
    device: str
    token: str = ""
    refused: str = ""


class CommandNews(Message, frozen=True, kw_only=True, tag="command_news"):
    """Where a one-shot command stands."""

    site: str
    device: str
    command: str
    id: str
    phase: CommandPhase
    message: str = ""
    progress: float = 0.0
    who: str = ""


class EventNews(Message, frozen=True, kw_only=True, tag="event"):
    """Something happened at a site that people should know of."""

    site: str
    kind: str
    device: str = ""
    message: str = ""
    who: str = ""
    time_us: int = 0
    good: bool = True


class Pong(Message, frozen=True, kw_only=True, tag="pong"):
    """Answer to `Ping`, with the hub's monotonic clock (µs) so that ages can be told."""

    n: int
    at_ms: float
    hub_us: int


class Problem(Message, frozen=True, kw_only=True, tag="problem"):
    """What you asked was not done, and why.

    Attributes:
        code: ``forbidden``, ``unknown``, ``offline``, ``invalid``, ``busy``, or ``store`` when
            the hub cannot tell who may do it, since its database does not answer.
        about: the tag of the message this answers.

    """

    code: str
    message: str
    about: str = ""


class SessionNews(Message, frozen=True, kw_only=True, tag="session"):
    """Your session ends soon; said in good time, so that a driver can stop and hand over.

    Attributes:
        ends_us: when (UTC, µs); 0 when it goes on after all.
        idle: touching the page keeps it; otherwise it ends then whatever you do: sign in again.

    """

    ends_us: int
    idle: bool = False


class Ended(Message, frozen=True, kw_only=True, tag="ended"):
    """Your session is over; the socket closes after this."""

    reason: str


class Shot(Message, frozen=True, kw_only=True, tag="shot"):
    """One picture. ``hub_us`` is the moment of capture on the hub's monotonic clock."""

    seq: int
    time_us: int
    hub_us: int
    width: int
    height: int
    format: str
    data: bytes


class Shown(Message, frozen=True, kw_only=True, tag="shown"):
    """The page has drawn picture ``seq``; the hub may send another. At most two are under way."""

    seq: Count


FromBrowser = Subscribe | Unsubscribe | Lease | Drive | Stop | Reset | Command | Ping
ToBrowser = (
    Greeting
    | SiteNews
    | Subscribed
    | Values
    | LeaseNews
    | TickNews
    | DriveNews
    | StopNews
    | ResetKey
    | CommandNews
    | EventNews
    | Pong
    | Problem
    | SessionNews
    | Ended
)
MediaToBrowser = Shot | Problem | Ended
MediaFromBrowser = Shown

FROM_BROWSER: Codec[FromBrowser] = Codec(FromBrowser, 1024 * 1024)
TO_BROWSER: Codec[ToBrowser] = Codec(ToBrowser)
MEDIA_TO_BROWSER: Codec[MediaToBrowser] = Codec(MediaToBrowser, MAX_PICTURE)
MEDIA_FROM_BROWSER: Codec[MediaFromBrowser] = Codec(MediaFromBrowser, 4096)
