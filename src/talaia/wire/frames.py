"""Every message between gateway and hub.

The gateway dials out twice: the *link* (``/gateway/link``) for all but pictures, and *media*
(``/gateway/media``) for pictures, so that a picture never stands before a driving frame. It
proves itself by ``Authorization: Bearer <gateway key>`` on both.

Long, because the messages of one link are read together, in one place.

Times ending in ``_us`` are microseconds; ``time_us`` is wall time (UTC since the epoch),
``mono_us`` is the sender's own monotonic clock, which only its sender can compare.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from msgspec import Meta

from talaia.wire.shape import PROTOCOL, Codec, Message

__all__ = [
    "LINK_FROM_GATEWAY",
    "LINK_FROM_HUB",
    "MEDIA_FROM_GATEWAY",
    "MEDIA_FROM_HUB",
    "Ack",
    "Beat",
    "BeatReply",
    "Bye",
    "CommandAsk",
    "CommandPhase",
    "CommandState",
    "Drive",
    "DriveState",
    "Event",
    "FromGateway",
    "FromHub",
    "Gap",
    "Hello",
    "LeaseAsk",
    "LeaseOp",
    "LeaseState",
    "Picture",
    "Reconnect",
    "ResetAsk",
    "ResetToken",
    "Samples",
    "Scalar",
    "StopAsk",
    "StopState",
    "Tick",
    "Watch",
    "Welcome",
]

Name = Annotated[str, Meta(min_length=1, max_length=200)]
Sentence = Annotated[str, Meta(max_length=2000)]
Count = Annotated[int, Meta(ge=0, le=2**62)]
Scalar = float | int | bool | str
# A picture is at most this large; a link frame is far smaller.
MAX_PICTURE = 8 * 1024 * 1024


class LeaseOp(StrEnum):
    """What is asked of the lease."""

    TAKE = "take"
    RENEW = "renew"
    FREE = "free"


class CommandPhase(StrEnum):
    """Where a one-shot command stands. The last five are final."""

    ACCEPTED = "accepted"
    RUNNING = "running"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    REFUSED = "refused"
    CANCELLED = "cancelled"
    UNKNOWN = "unknown"


# ── gateway to hub ──────────────────────────────────────────────────────────────────────────


class Hello(Message, frozen=True, kw_only=True, tag="hello"):
    """First frame of a link.

    Attributes:
        boot: names this run of the gateway; sample sequences count from 0 in each.
        description: the site description as YAML text, the gateway's own copy.
        catalogue: names the channel list that `Samples.channel` indexes (see `Site.channels`).

    """

    protocol: int = PROTOCOL
    version: Sentence = ""
    site: Name
    boot: Name
    description: Annotated[str, Meta(max_length=4 * 1024 * 1024)]
    catalogue: Name
    time_us: int = 0


class Samples(Message, frozen=True, kw_only=True, tag="samples"):
    """A batch of samples; see `wire.columns`. Sample i has the sequence number ``first + i``.

    ``addresses`` is set when the batch was indexed by another channel list than the hello's
    (kept on disk since before the description changed).
    """

    boot: Name
    first: Count
    catalogue: Name
    base_us: int
    channel: bytes
    offset: bytes
    value: bytes
    texts: dict[int, Sentence] = {}
    addresses: list[Name] = []
    live: bool = True


class Gap(Message, frozen=True, kw_only=True, tag="gap"):
    """Samples ``first`` to ``last`` of a boot are lost, with the reason and the time they span."""

    boot: Name
    first: Count
    last: Count
    from_us: int
    to_us: int
    reason: Sentence


class LeaseState(Message, frozen=True, kw_only=True, tag="lease"):
    """Who holds a device. Sent on every change, and as the answer to each `LeaseAsk`.

    Attributes:
        session: the holder's session, empty while nobody holds it.
        asked: the session that this answers, empty when it answers nobody.
        refused: why ``asked`` did not get it.

    """

    device: Name
    session: str = ""
    who: Sentence = ""
    epoch: Count = 0
    remains_ms: int = 0
    asked: str = ""
    refused: Sentence = ""


class Tick(Message, frozen=True, kw_only=True, tag="tick"):
    """The gateway's own time mark, sent at 20 Hz while any lease is held; drivers echo it."""

    tick: Count


class DriveState(Message, frozen=True, kw_only=True, tag="drive_state"):
    """What the robot is being told: velocities (m/s, rad/s), speed cap (0 to 1), loop time."""

    device: Name
    linear: float
    angular: float
    cap: float
    loop_ms: float = 0.0
    accepted: Count = 0
    refused: Count = 0
    why: Sentence = ""


class StopState(Message, frozen=True, kw_only=True, tag="stop_state"):
    """STOP (software): latched at the gateway; confirmed once the robot itself stands still."""

    device: Name
    latched: bool
    confirmed: bool = False
    who: Sentence = ""
    time_us: int = 0
    id: str = ""


class ResetToken(Message, frozen=True, kw_only=True, tag="reset_token"):
    """The second step's key to a reset of STOP, for the session that asked."""

    device: Name
    session: Name
    token: str = ""
    refused: Sentence = ""


class CommandState(Message, frozen=True, kw_only=True, tag="command_state"):
    """Where a one-shot command stands, in the robot's own words where it gave any."""

    id: Name
    device: Name
    command: Name
    phase: CommandPhase
    message: Sentence = ""
    progress: float = 0.0
    who: Sentence = ""


class Event(Message, frozen=True, kw_only=True, tag="event"):
    """Something worth writing down: adapter lost or back, drive started or ended, a refusal."""

    kind: Name
    device: str = ""
    message: Sentence = ""
    who: Sentence = ""
    time_us: int = 0
    good: bool = True


# ── both ways ───────────────────────────────────────────────────────────────────────────────


class Beat(Message, frozen=True, kw_only=True, tag="beat"):
    """Are you there? Sent every second; three without a reply and the peer counts as gone."""

    n: Count
    mono_us: int


class BeatReply(Message, frozen=True, kw_only=True, tag="beat_reply"):
    """Yes. Echoes the beat and adds the answerer's monotonic clock, so clocks can be compared."""

    n: Count
    mono_us: int
    peer_us: int


class Bye(Message, frozen=True, kw_only=True, tag="bye"):
    """The link is closed on purpose."""

    reason: Sentence = ""


# ── hub to gateway ──────────────────────────────────────────────────────────────────────────


class Welcome(Message, frozen=True, kw_only=True, tag="welcome"):
    """Answer to `Hello`. ``acked`` is one past the last sequence of this boot that is stored."""

    protocol: int = PROTOCOL
    version: Sentence = ""
    acked: Count = 0
    time_us: int = 0


class Ack(Message, frozen=True, kw_only=True, tag="ack"):
    """Every sample of ``boot`` below sequence ``below`` is stored for good."""

    boot: Name
    below: Count


class LeaseAsk(Message, frozen=True, kw_only=True, tag="lease_ask"):
    """Take, renew or free the lease of a device for a session."""

    device: Name
    session: Name
    who: Name
    op: LeaseOp


class Drive(Message, frozen=True, kw_only=True, tag="drive"):
    """A driving frame.

    Attributes:
        seq: rises with every frame of an epoch.
        tick: the newest `Tick` the driver's page has seen.
        held_ms: how long ago it saw it, by its own clock.
        ttl_ms: refuse this frame when it is older; 0 takes the description's.
        linear: forward (m/s). angular: counter-clockwise (rad/s), as in REP-103.
        picture_ms: age of the picture the driver looks at; -1 when there is none.

    """

    device: Name
    session: Name
    epoch: Count
    seq: Count
    tick: Count
    held_ms: float = 0.0
    ttl_ms: float = 0.0
    linear: float
    angular: float
    picture_ms: float = -1.0


class StopAsk(Message, frozen=True, kw_only=True, tag="stop_ask"):
    """STOP (software). Needs no lease. Repeated until a `StopState` with this id comes back."""

    device: Name
    id: Name
    who: Name


class ResetAsk(Message, frozen=True, kw_only=True, tag="reset_ask"):
    """Release STOP. Without ``token``: ask for one. With it: release. Needs the lease."""

    device: Name
    session: Name
    epoch: Count
    who: Name
    token: str = ""


class CommandAsk(Message, frozen=True, kw_only=True, tag="command_ask"):
    """Do this once. The id is the asker's; an id is acted on at most once."""

    id: Name
    device: Name
    command: Name
    args: dict[str, Scalar] = {}
    ttl_ms: float
    who: Name


class Watch(Message, frozen=True, kw_only=True, tag="watch"):
    """The streams (``device/stream``) that anyone looks at now; all others rest."""

    streams: list[Name]


class Reconnect(Message, frozen=True, kw_only=True, tag="reconnect"):
    """Connect anew to a device on the robot's side; an `Event` tells how it went.

    Driving and STOP are not touched by it.
    """

    device: Name
    who: Name


class Picture(Message, frozen=True, kw_only=True, tag="picture"):
    """One picture of a stream, stamped at the gateway."""

    stream: Name
    seq: Count
    time_us: int
    mono_us: int
    width: int
    height: int
    format: Name = "jpeg"
    data: bytes


FromGateway = (
    Hello
    | Samples
    | Gap
    | LeaseState
    | Tick
    | DriveState
    | StopState
    | ResetToken
    | CommandState
    | Event
    | Beat
    | BeatReply
    | Bye
)
FromHub = (
    Welcome
    | Ack
    | LeaseAsk
    | Drive
    | StopAsk
    | ResetAsk
    | CommandAsk
    | Watch
    | Reconnect
    | Beat
    | BeatReply
    | Bye
)
MediaFromGateway = Picture | Beat | BeatReply
MediaFromHub = Beat | BeatReply | Bye

LINK_FROM_GATEWAY: Codec[FromGateway] = Codec(FromGateway, 8 * 1024 * 1024)
LINK_FROM_HUB: Codec[FromHub] = Codec(FromHub, 1024 * 1024)
MEDIA_FROM_GATEWAY: Codec[MediaFromGateway] = Codec(MediaFromGateway, MAX_PICTURE)
MEDIA_FROM_HUB: Codec[MediaFromHub] = Codec(MediaFromHub, 64 * 1024)
