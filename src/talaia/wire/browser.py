"""Every message between hub and browser.

Two sockets: ``/ws`` for all but pictures, and one ``/ws/media?site=…&stream=…`` for each camera
a page shows. MessagePack by default; ``?form=json`` gives the JSON form. The session cookie (or
a token) says who it is; rights are checked on every message, both ways.

Long, because the messages of one socket are read together, in one place.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.wire.columns import MAX_SAMPLES
from talaia.wire.frames import (
    MAX_PICTURE,
    Arguments,
    ChannelColumn,
    CommandPhase,
    Count,
    LeaseOp,
    Micros,
    Millis,
    Name,
    OffsetColumn,
    Pixels,
    Sentence,
    Share,
    Texts,
    Thing,
    Units,
    ValueColumn,
    Word,
)
from talaia.wire.shape import PROTOCOL, Codec, Message

__all__ = [
    "FROM_BROWSER",
    "MEDIA_FROM_BROWSER",
    "MEDIA_TO_BROWSER",
    "TO_BROWSER",
    "AlarmNews",
    "AnomalyNews",
    "BoxesAsk",
    "Cancel",
    "Command",
    "CommandNews",
    "DeviceNews",
    "Drive",
    "DriveNews",
    "Ended",
    "EventNews",
    "FromBrowser",
    "Glance",
    "Greeting",
    "InterlockNews",
    "Lease",
    "LeaseForce",
    "LeaseNews",
    "Override",
    "Ping",
    "Pong",
    "Problem",
    "Reset",
    "ResetKey",
    "SessionNews",
    "Shot",
    "ShotBoxes",
    "Shown",
    "SightingNews",
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

    sub: Count


class Lease(Message, frozen=True, kw_only=True, tag="lease"):
    """Take, renew or free the lease of a device; ask its holder for it, or answer an ask."""

    site: Name
    device: Name
    op: LeaseOp


class LeaseForce(Message, frozen=True, kw_only=True, tag="lease_force"):
    """Take the lease from its holder, who said no or nothing to your ask."""

    site: Name
    device: Name


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
    token: Word = ""


class Command(Message, frozen=True, kw_only=True, tag="command"):
    """Ask a device to do something once. ``id`` is the page's own, never used twice.

    ``units`` are those the page showed beside the arguments, and ``over`` is somebody else's
    command that the person was shown and wants to interrupt; see `frames.CommandAsk`.
    """

    site: Name
    device: Name
    command: Name
    id: Name
    args: Arguments = {}
    units: Units = {}
    over: Word = ""


class Cancel(Message, frozen=True, kw_only=True, tag="cancel"):
    """End a command that is under way, if the robot can; `CommandNews` tells what came of it."""

    site: Name
    device: Name
    id: Name


class Override(Message, frozen=True, kw_only=True, tag="override"):
    """Override a condition of an interlock for so many seconds, with the reason; 0 s ends that.

    Attributes:
        condition: which, as `InterlockNews` names it; empty for the one that locks.

    """

    site: Name
    interlock: Name
    reason: Annotated[str, Meta(max_length=500)] = ""
    seconds: Annotated[float, Meta(ge=0, le=86_400)]
    condition: Word = ""


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

    protocol: Count = PROTOCOL
    version: Word = ""
    who: Word
    role: Word
    time_us: Micros


class SiteNews(Message, frozen=True, kw_only=True, tag="site"):
    """A site's link came up or went down, or its description changed (``catalogue``).

    Attributes:
        rival_us: another gateway with this one's key was there then (UTC) and is kept out; 0 when
            none has been for two minutes.

    """

    site: Word
    online: bool
    since_us: Micros
    catalogue: Word = ""
    loop_ms: float = 0.0
    skew_ms: float = 0.0
    why: Sentence = ""
    rival_us: Micros = 0


class Subscribed(Message, frozen=True, kw_only=True, tag="subscribed"):
    """Answer to `Subscribe`. Channels you may not see, or that are not there, are refused."""

    sub: Count
    refused: Annotated[list[Name], Meta(max_length=10_000)] = []


class Values(Message, frozen=True, kw_only=True, tag="values"):
    """Samples of a subscription as columns; see `wire.columns`.

    The first `Values` of a subscription holds the last known sample of each channel;
    ``age_ms`` then tells the age of each by the hub's clock, by position in the batch.
    """

    sub: Count
    base_us: Micros
    channel: ChannelColumn
    offset: OffsetColumn
    value: ValueColumn
    texts: Texts = {}
    age_ms: Annotated[list[float], Meta(max_length=MAX_SAMPLES)] = []


class LeaseNews(Message, frozen=True, kw_only=True, tag="lease_news"):
    """Who holds a device. ``epoch`` is not 0 only when it is you (``yours``).

    Attributes:
        rival: who asks the holder for it.
        asking: that is you.
        answer_ms: the holder may answer for so long yet.
        refused: why you did not get it.
        forceable: an admin may force it now.

    """

    site: Word
    device: Word
    holder: Word = ""
    yours: bool = False
    epoch: Count = 0
    remains_ms: Millis = 0
    rival: Word = ""
    asking: bool = False
    answer_ms: Millis = 0
    refused: Sentence = ""
    forceable: bool = False


class TickNews(Message, frozen=True, kw_only=True, tag="tick"):
    """The gateway's newest time mark; echo it in `Drive`."""

    site: Word
    tick: Count


class DriveNews(Message, frozen=True, kw_only=True, tag="drive_news"):
    """What the robot is being told; see `frames.DriveState`."""

    site: Word
    device: Word
    linear: float
    angular: float
    cap: float
    loop_ms: float = 0.0
    accepted: Count = 0
    refused: Count = 0
    why: Sentence = ""
    sent: Word = ""


class StopNews(Message, frozen=True, kw_only=True, tag="stop_news"):
    """STOP (software): see `frames.StopState`."""

    site: Word
    device: Word
    latched: bool
    confirmed: bool = False
    who: Word = ""
    time_us: Micros = 0
    id: Word = ""


class ResetKey(Message, frozen=True, kw_only=True, tag="reset_key"):
    """The token for the second step of a reset, or why there is none."""

    site: Word
    device: Word
    token: Word = ""
    refused: Sentence = ""


class CommandNews(Message, frozen=True, kw_only=True, tag="command_news"):
    """Where a one-shot command stands; ``blocked_by`` as in `frames.CommandState`.

    A page that comes while somebody acts is told of that first.

    Attributes:
        acting: who acts on the device by it, and on what, in words; empty: nobody, or no longer.
        acting_s: for how long already (s).

    """

    site: Word
    device: Word
    command: Word
    id: Word
    phase: CommandPhase
    message: Sentence = ""
    progress: float = 0.0
    who: Word = ""
    blocked_by: Word = ""
    acting: Sentence = ""
    acting_s: float = 0.0


class InterlockNews(Message, frozen=True, kw_only=True, tag="interlock_news"):
    """How an interlock of a site stands; shown on every page while it locks or is overridden.

    Attributes:
        name: what people call it.
        locked: it refuses or slows what it guards, unless overridden.
        unsafe: its conditions hold now; not so while it only waits for its dwell time.
        since_us: locked since (UTC).
        clears_ms: released after so long, if nothing unsafe comes between.
        refuses: what it refuses, as people call it; of the devices that you may see.
        targets: the same, as ``<device>/<command>``, ``<device>/drive`` or ``<device>/*``.
        slows: what it slows down, as people call it, and to what; of the devices that you may see.
        slowed: the same, as ``<device>/drive``.
        overridable: an admin may override it now.
        override_ms: overridden for so long yet, by whom and why.
        longest_s: you may override it for so long at the most; 0: you may not.
        condition: the condition that is overridden, or else the one that locks.
        no_override: why nobody may override it now, if so.

    """

    site: Word
    interlock: Word
    name: Word
    locked: bool
    unsafe: bool = False
    why: Sentence = ""
    since_us: Micros = 0
    clears_ms: Millis = 0
    refuses: Annotated[list[Sentence], Meta(max_length=1000)] = []
    targets: Annotated[list[Sentence], Meta(max_length=1000)] = []
    slows: Annotated[list[Sentence], Meta(max_length=1000)] = []
    slowed: Annotated[list[Sentence], Meta(max_length=1000)] = []
    overridable: bool = False
    overridden_by: Word = ""
    reason: Sentence = ""
    override_ms: Millis = 0
    longest_s: float = 0.0
    condition: Word = ""
    no_override: Sentence = ""


class DeviceNews(Message, frozen=True, kw_only=True, tag="device_news"):
    """Whether a site's gateway reaches a device; a page hears of those that it does not.

    Attributes:
        why: why it is not reached.
        since_us: not reached since (UTC).

    """

    site: Word
    device: Word
    reached: bool
    why: Sentence = ""
    since_us: Micros = 0


class AlarmNews(Message, frozen=True, kw_only=True, tag="alarm"):
    """How an alarm stands; told to a page that comes, and whenever it changes.

    Attributes:
        device: the one device it is about; empty: more than one, or the whole site.
        phase: ``normal``, ``active``, ``acknowledged`` or ``cleared`` (over and not acknowledged).
        why: what raised it.
        known: whether it can be judged now; a normal one that cannot be is not well.
        raised_us: when it was raised last, and likewise; 0: not yet, or not since it was raised.
        shelved_until_us: it is put aside until then; 0: it is not.
        undelivered: why a message of it did not reach somebody, or may not have.
        signals: channels that it looks at.
        made: made in the page; the description's own are changed there.
        gone: there is no such alarm any more.

    """

    site: Word
    alarm: Word
    device: Word = ""
    name: Word
    kind: Word
    severity: Word
    phase: Word
    why: Sentence = ""
    known: bool = True
    unknown_why: Sentence = ""
    raised_us: Micros = 0
    cleared_us: Micros = 0
    acked_us: Micros = 0
    acked_by: Word = ""
    assigned: Word = ""
    shelved_until_us: Micros = 0
    shelved_by: Word = ""
    shelved_why: Sentence = ""
    undelivered: Sentence = ""
    advice: Sentence = ""
    signals: Annotated[list[Word], Meta(max_length=1000)] = []
    made: bool = False
    gone: bool = False


class SightingNews(Message, frozen=True, kw_only=True, tag="sighting"):
    """Something came into sight of a camera, is seen surer or more often, or is gone.

    Attributes:
        camera: the stream, ``device/stream``.
        many: how many at once, at the most so far.
        confidence: of the surest so far.
        ended_us: when it was seen last; 0 while it is in sight.

    """

    site: Name
    id: Count
    camera: Name
    label: Name
    many: Count
    confidence: Share
    began_us: Micros
    ended_us: Micros = 0


class AnomalyNews(Message, frozen=True, kw_only=True, tag="anomaly"):
    """How a detector of a signal stands, told when that changes; its scores come as `Values`.

    Subscribe to ``<signal>~<detector>`` for the scores. What stood before a page came is asked for
    over HTTP.

    Attributes:
        address: of the signal.
        detector: its word in the site description.
        on: an anomaly is on.
        from_us: when the newest anomaly began (UTC); 0: there was none yet.
        to_us: its last high sample (UTC); 0 while it is on.
        score: the newest.
        why: why the newest anomaly is one, in words.
        forgiven: a person said that it was none.
        learning: so many samples until it has learned; before, it tells little.

    """

    site: Word
    device: Word
    address: Word
    detector: Word
    on: bool = False
    from_us: Micros = 0
    to_us: Micros = 0
    score: float = 0.0
    why: Sentence = ""
    forgiven: bool = False
    learning: Count = 0


class EventNews(Message, frozen=True, kw_only=True, tag="event"):
    """Something happened at a site that people should know of."""

    site: Word
    kind: Word
    device: Word = ""
    message: Sentence = ""
    who: Word = ""
    time_us: Micros = 0
    good: bool = True


class Pong(Message, frozen=True, kw_only=True, tag="pong"):
    """Answer to `Ping`, with the hub's monotonic clock (µs) so that ages can be told."""

    n: Count
    at_ms: float
    hub_us: Micros


class Problem(Message, frozen=True, kw_only=True, tag="problem"):
    """What you asked was not done, and why.

    Attributes:
        code: ``forbidden``, ``unknown``, ``offline``, ``invalid``, ``busy``, or ``store`` when
            the hub cannot tell who may do it, since its database does not answer.
        about: the tag of the message this answers.

    """

    code: Word
    message: Sentence
    about: Word = ""


class SessionNews(Message, frozen=True, kw_only=True, tag="session"):
    """Your session ends soon; said in good time, so that a driver can stop and hand over.

    Attributes:
        ends_us: when (UTC, µs); 0 when it goes on after all.
        idle: touching the page keeps it; otherwise it ends then whatever you do: sign in again.

    """

    ends_us: Micros
    idle: bool = False


class Ended(Message, frozen=True, kw_only=True, tag="ended"):
    """Your session is over; the socket closes after this."""

    reason: Sentence


class Shot(Message, frozen=True, kw_only=True, tag="shot"):
    """One picture. ``hub_us`` is the moment of capture on the hub's monotonic clock.

    Attributes:
        format: ``jpeg`` or ``h264``; see `talaia.wire.frames.Picture`.
        key: it needs no picture before it.
        codec: of ``h264``: as WebCodecs names it.
        small: it is smaller than the camera's own, since the connection is slow.

    """

    seq: Count
    time_us: Micros
    hub_us: Micros
    width: Pixels
    height: Pixels
    format: Word
    key: bool = True
    codec: Word = ""
    small: bool = False
    data: Annotated[bytes, Meta(max_length=MAX_PICTURE)]


class Shown(Message, frozen=True, kw_only=True, tag="shown"):
    """The page has drawn picture ``seq``; the hub may send another. At most two are under way."""

    seq: Count


class Glance(Message, frozen=True, kw_only=True, tag="glance"):
    """The page is not looked at closely now (hidden): a picture a second will do, or no more."""

    still: bool


class ShotBoxes(Message, frozen=True, kw_only=True, tag="shot_boxes"):
    """What is seen on the picture ``seq``, which may be shown already, or never come.

    Attributes:
        time_us: when that picture was taken.
        things: the surest first.

    """

    seq: Count
    time_us: Micros
    things: Annotated[list[Thing], Meta(max_length=100)]


class BoxesAsk(Message, frozen=True, kw_only=True, tag="boxes_ask"):
    """The page wants `ShotBoxes` from here on, or no more."""

    on: bool


FromBrowser = (
    Subscribe
    | Unsubscribe
    | Lease
    | LeaseForce
    | Drive
    | Stop
    | Reset
    | Command
    | Cancel
    | Override
    | Ping
)
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
    | InterlockNews
    | DeviceNews
    | AlarmNews
    | SightingNews
    | AnomalyNews
    | EventNews
    | Pong
    | Problem
    | SessionNews
    | Ended
)
MediaToBrowser = Shot | ShotBoxes | Problem | Ended
MediaFromBrowser = Shown | Glance | BoxesAsk

FROM_BROWSER: Codec[FromBrowser] = Codec(FromBrowser, 1024 * 1024)
TO_BROWSER: Codec[ToBrowser] = Codec(ToBrowser)
MEDIA_TO_BROWSER: Codec[MediaToBrowser] = Codec(MediaToBrowser, MAX_PICTURE)
MEDIA_FROM_BROWSER: Codec[MediaFromBrowser] = Codec(MediaFromBrowser, 4096)
