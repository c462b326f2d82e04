"""Every message between gateway and hub.

The gateway dials out twice: the *link* (``/gateway/link``) for all but pictures, and *media*
(``/gateway/media``) for pictures, so that a picture never stands before a driving frame; and a
third time (``/gateway/files``) while it has recordings to hand over. It proves itself by
``Authorization: Bearer <gateway key>`` on each.

Long, because the messages of one link are read together, in one place.

Times ending in ``_us`` are microseconds; ``time_us`` is wall time (UTC since the epoch),
``mono_us`` is the sender's own monotonic clock, which only its sender can compare.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from msgspec import Meta

from talaia.wire.columns import MAX_SAMPLES
from talaia.wire.shape import PROTOCOL, Codec, Message

__all__ = [
    "FILES_FROM_GATEWAY",
    "FILES_FROM_HUB",
    "LINK_FROM_GATEWAY",
    "LINK_FROM_HUB",
    "MEDIA_FROM_GATEWAY",
    "MEDIA_FROM_HUB",
    "PIECE",
    "Ack",
    "Again",
    "ArchiveOffer",
    "Beat",
    "BeatReply",
    "Boxes",
    "Bye",
    "ChangeAsk",
    "ChangePhase",
    "ChangeState",
    "CommandAsk",
    "CommandCancel",
    "CommandPhase",
    "CommandState",
    "Described",
    "DeviceState",
    "Drive",
    "DriveState",
    "EnclosureState",
    "Event",
    "FileHave",
    "FileOffer",
    "FilePiece",
    "FilmOffer",
    "Form",
    "FromGateway",
    "FromHub",
    "Gap",
    "Hello",
    "InterlockState",
    "KeyAsk",
    "LeaseAsk",
    "LeaseForce",
    "LeaseOp",
    "LeaseState",
    "Newest",
    "OverrideAsk",
    "Picture",
    "Problem",
    "Reconnect",
    "RecordAsk",
    "RecordState",
    "ResetAsk",
    "ResetToken",
    "Samples",
    "Scalar",
    "Seen",
    "StopAsk",
    "StopState",
    "Thing",
    "Tick",
    "Trouble",
    "Watch",
    "Welcome",
]

Name = Annotated[str, Meta(min_length=1, max_length=200)]
Sentence = Annotated[str, Meta(max_length=2000)]
Count = Annotated[int, Meta(ge=0, le=2**62)]
# May be empty.
Word = Annotated[str, Meta(max_length=200)]
Micros = Annotated[int, Meta(ge=-(2**62), le=2**62)]
Millis = Annotated[int, Meta(ge=0, le=2**40)]
Pixels = Annotated[int, Meta(ge=0, le=16_384)]
Scalar = float | int | bool | Annotated[str, Meta(max_length=10_000)]
Arguments = Annotated[dict[Name, Scalar], Meta(max_length=100)]
Units = Annotated[dict[Name, Word], Meta(max_length=100)]
# One column of a batch: so many bytes a sample; see `wire.columns`.
ChannelColumn = Annotated[bytes, Meta(max_length=2 * MAX_SAMPLES)]
OffsetColumn = Annotated[bytes, Meta(max_length=4 * MAX_SAMPLES)]
ValueColumn = Annotated[bytes, Meta(max_length=8 * MAX_SAMPLES)]
Texts = Annotated[dict[int, Sentence], Meta(max_length=MAX_SAMPLES)]
FormList = Annotated[list[Word], Meta(max_length=16)]
Forms = Annotated[dict[Name, FormList], Meta(max_length=1000)]
Digest = Annotated[str, Meta(pattern="^[0-9a-f]{64}$")]
FileId = Annotated[str, Meta(pattern="^[0-9A-Za-z]{1,32}(-[0-9a-z]{1,16})?$")]
# A description's text, deflated (zlib), so that it stands before a driving frame for little.
Deflated = Annotated[bytes, Meta(max_length=1024 * 1024)]
Share = Annotated[float, Meta(ge=0, le=1)]
Thumbnail = Annotated[bytes, Meta(max_length=64 * 1024)]
AskedText = Annotated[bytes, Meta(max_length=768 * 1024)]
# Bytes of a recording that go in one frame.
PIECE = 64 * 1024
# A picture is at most this large; a link frame is far smaller.
MAX_PICTURE = 8 * 1024 * 1024


class LeaseOp(StrEnum):
    """What is asked of the lease."""

    TAKE = "take"
    RENEW = "renew"
    FREE = "free"
    # Who has none asks the holder for it (or takes it, if it is free); `FREE` ends the ask.
    ASK = "ask"
    # The holder's answer to an ask.
    ACCEPT = "accept"
    DENY = "deny"


class CommandPhase(StrEnum):
    """Where a one-shot command stands. The last five are final."""

    ACCEPTED = "accepted"
    RUNNING = "running"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    REFUSED = "refused"
    CANCELLED = "cancelled"
    UNKNOWN = "unknown"


class ChangePhase(StrEnum):
    """Where a change of the description stands. The last two are final."""

    WAITING = "waiting"
    APPLIED = "applied"
    REFUSED = "refused"


class Form(StrEnum):
    """How a picture travels: two sizes of each of two encodings, and now and then one picture.

    On the wire it is a plain word, so that a peer may know more of them than we do.
    """

    H264 = "h264"
    H264_SMALL = "h264_small"
    JPEG = "jpeg"
    JPEG_SMALL = "jpeg_small"
    STILL = "still"


# ── gateway to hub ──────────────────────────────────────────────────────────────────────────


class Hello(Message, frozen=True, kw_only=True, tag="hello"):
    """First frame of a link.

    Attributes:
        boot: names this run of the gateway; sample sequences count from 0 in each.
        description: the site description as YAML text, the gateway's own copy.
        catalogue: names the channel list that `Samples.channel` indexes (see `Site.channels`).
        source: the text of the description's file as a person wrote it, deflated; empty where it
            is not from one file that may be changed.
        accepts: which changes the gateway takes from the hub: ``no``, ``readings`` or ``all``.

    """

    protocol: Count = PROTOCOL
    version: Sentence = ""
    site: Name
    boot: Name
    description: Annotated[str, Meta(max_length=4 * 1024 * 1024)]
    catalogue: Name
    time_us: Micros = 0
    source: Deflated = b""
    accepts: Word = ""


class Described(Message, frozen=True, kw_only=True, tag="described"):
    """The gateway goes by another description from here on; the link and the boot stay.

    Attributes:
        description: as in `Hello`, deflated.
        catalogue: as in `Hello`; batches with the one before may still come behind this.
        addresses: of the channels that the new catalogue names, in order.
        renamed: channels that have another address now, by the former one.
        source: as in `Hello`.
        id: of the `ChangeAsk` that brought it; empty when the file was changed at the gateway.
        who: asked for it.

    """

    description: Deflated
    catalogue: Name
    addresses: Annotated[list[Name], Meta(max_length=MAX_SAMPLES)] = []
    renamed: Annotated[dict[Name, Name], Meta(max_length=MAX_SAMPLES)] = {}
    source: Deflated = b""
    id: Word = ""
    who: Sentence = ""


class Problem(Message, frozen=True, kw_only=True, tag="problem"):
    """What does not fit in a description: where, what, and what to do."""

    where: Sentence
    problem: Sentence
    remedy: Sentence = ""


class ChangeState(Message, frozen=True, kw_only=True, tag="change_state"):
    """Where a change that was asked for stands; or, without an id, one of the file's own.

    Attributes:
        message: what it waits for, or why it was refused.
        problems: what does not fit in it; not all, if there are many.

    """

    id: Word = ""
    phase: ChangePhase
    message: Sentence = ""
    problems: Annotated[list[Problem], Meta(max_length=100)] = []


class Samples(Message, frozen=True, kw_only=True, tag="samples"):
    """A batch of samples; see `wire.columns`. Sample i has the sequence number ``first + i``.

    ``addresses`` is set when the batch was indexed by another channel list than the hello's
    (kept on disk since before the description changed).
    """

    boot: Name
    first: Count
    catalogue: Name
    base_us: Micros
    channel: ChannelColumn
    offset: OffsetColumn
    value: ValueColumn
    texts: Texts = {}
    addresses: Annotated[list[Name], Meta(max_length=MAX_SAMPLES)] = []
    live: bool = True


class Newest(Message, frozen=True, kw_only=True, tag="newest"):
    """The newest sample of channels, whatever its age; see `wire.newest`.

    Told when a link comes up, before anything old, and when live samples were dropped: what was
    said while nobody heard it, with silence after it, is what counts now. Each is one of the run's
    samples, with its own number, and comes with the old ones once more.
    Only to hubs that take ``newest`` (see `Welcome`).

    Attributes:
        sequence: numbers in the run, rising (i64).
        time_us: times (i64).
        age_ms: how long ago each was heard (f64), by the gateway's clock.
        addresses: as in `Samples`.

    """

    boot: Name
    catalogue: Name
    channel: ChannelColumn
    sequence: ValueColumn
    time_us: ValueColumn
    value: ValueColumn
    age_ms: ValueColumn
    texts: Texts = {}
    addresses: Annotated[list[Name], Meta(max_length=MAX_SAMPLES)] = []


class Gap(Message, frozen=True, kw_only=True, tag="gap"):
    """Samples ``first`` to ``last`` of a boot are lost, with the reason and the time they span."""

    boot: Name
    first: Count
    last: Count
    from_us: Micros
    to_us: Micros
    reason: Sentence


class LeaseState(Message, frozen=True, kw_only=True, tag="lease"):
    """Who holds a device. Sent on every change, and as the answer to each `LeaseAsk`.

    Attributes:
        session: the holder's session, empty while nobody holds it.
        rival: the session that asks the holder for it, empty when none does.
        rival_ms: the holder may answer for so long yet.
        asked: the session that this answers, empty when it answers nobody.
        refused: why ``asked`` did not get it.
        forceable: it was denied, or not answered in time, and may be forced now.

    """

    device: Name
    session: Word = ""
    who: Sentence = ""
    epoch: Count = 0
    remains_ms: Millis = 0
    rival: Word = ""
    rival_who: Sentence = ""
    rival_ms: Millis = 0
    asked: Word = ""
    refused: Sentence = ""
    forceable: bool = False


class Tick(Message, frozen=True, kw_only=True, tag="tick"):
    """The gateway's own time mark, sent at 20 Hz while any lease is held; drivers echo it."""

    tick: Count


class DriveState(Message, frozen=True, kw_only=True, tag="drive_state"):
    """What the robot is being told: velocities (m/s, rad/s), speed cap (0 to 1), loop time.

    ``sent``: to a robot that is driven by characters, those since its last ``s``; its velocities
    are then what these add up to, and NaN where that is not described.
    """

    device: Name
    linear: float
    angular: float
    cap: float
    loop_ms: float = 0.0
    accepted: Count = 0
    refused: Count = 0
    why: Sentence = ""
    sent: Word = ""


class StopState(Message, frozen=True, kw_only=True, tag="stop_state"):
    """STOP (software): latched at the gateway; confirmed once the robot itself stands still."""

    device: Name
    latched: bool
    confirmed: bool = False
    who: Sentence = ""
    time_us: Micros = 0
    id: Word = ""


class EnclosureState(Message, frozen=True, kw_only=True, tag="enclosure"):
    """An enclosure that people are to look at. Only to hubs that take it.

    Sent on every change, and of all at the start of a link.

    Attributes:
        why: it should be closed and cannot be shown to be, or its sensors disagree; empty when
            neither is so.

    """

    enclosure: Name
    why: Sentence = ""


class ResetToken(Message, frozen=True, kw_only=True, tag="reset_token"):
    """The second step's key to a reset of STOP, for the session that asked."""

    device: Name
    session: Name
    token: Word = ""
    refused: Sentence = ""


class CommandState(Message, frozen=True, kw_only=True, tag="command_state"):
    """Where a one-shot command stands, in the robot's own words where it gave any.

    Attributes:
        blocked_by: refused because of this command (its id) of somebody else, which is under way:
            asked anew with it as ``over``, it is done all the same.
        acting: who acts on the device by it, and on what, in words; empty: nobody, or no longer.
        acting_s: for how long already (s).
        over: told once, as it begins: whose command it interrupts, in words, with its id.

    """

    id: Name
    device: Name
    command: Name
    phase: CommandPhase
    message: Sentence = ""
    progress: float = 0.0
    who: Sentence = ""
    blocked_by: Word = ""
    acting: Sentence = ""
    acting_s: float = 0.0
    over: Sentence = ""


class Event(Message, frozen=True, kw_only=True, tag="event"):
    """Something worth writing down: adapter lost or back, drive started or ended, a refusal."""

    kind: Name
    device: Word = ""
    message: Sentence = ""
    who: Sentence = ""
    time_us: Micros = 0
    good: bool = True


class InterlockState(Message, frozen=True, kw_only=True, tag="interlock"):
    """How an interlock stands. Sent on every change, and of all at the start of a link.

    Attributes:
        locked: it refuses what it guards, unless overridden.
        unsafe: its conditions hold now; not so while it only waits for its dwell time.
        for_ms: locked for so long.
        clears_ms: it is released after so long, if nothing unsafe comes between.
        override_ms: overridden for so long yet, by whom and why.
        condition: the condition that is overridden, or else the one that locks.
        no_override: why that may not be overridden now, if so.

    """

    interlock: Name
    locked: bool
    unsafe: bool = False
    why: Sentence = ""
    for_ms: Millis = 0
    clears_ms: Millis = 0
    overridden_by: Sentence = ""
    reason: Sentence = ""
    override_ms: Millis = 0
    condition: Word = ""
    no_override: Sentence = ""


class RecordState(Message, frozen=True, kw_only=True, tag="record_state"):
    """Whether raw topics are being recorded. Sent on every change and at the start of a link.

    Attributes:
        id: the recording's own name; empty while there is none.
        since_us: its earliest message.
        ends_ms: it ends by itself after so long.
        problem: why the last one failed, or nothing can be recorded.
        films: cameras that are being filmed.
        can_film: whether this gateway can film at all.

    """

    on: bool
    id: Word = ""
    why: Sentence = ""
    who: Sentence = ""
    since_us: Micros = 0
    ends_ms: Millis = 0
    problem: Sentence = ""
    films: Annotated[list[Name], Meta(max_length=1000)] = []
    can_film: bool = False


class FileOffer(Message, frozen=True, kw_only=True, tag="file_offer"):
    """A recording that the gateway has, and hands over if the hub says how much of it it has.

    Attributes:
        id: the recording's own name, never used twice by a site.
        size: bytes.
        digest: SHA-256 of all of it.
        why: what began it.

    """

    id: FileId
    size: Count
    digest: Digest
    begin_us: Micros
    end_us: Micros
    why: Sentence = ""
    who: Sentence = ""
    messages: Count = 0
    topics: Annotated[list[Name], Meta(max_length=1000)] = []
    note: Sentence = ""


class FilmOffer(Message, frozen=True, kw_only=True, tag="film_offer"):
    """The gateway has a film of a camera (MP4); answered and taken as a `FileOffer` is.

    The time of a picture is ``begin_us`` and its time in the film.

    Attributes:
        id: the film's own name, never used twice by a site, nor for a recording.
        digest: SHA-256 of all of it.
        begin_us: when its first picture came.
        end_us: when its last one did.
        why: what began it.

    """

    id: FileId
    stream: Name
    size: Count
    digest: Digest
    begin_us: Micros
    end_us: Micros
    pictures: Count = 0
    why: Sentence = ""
    who: Sentence = ""
    note: Sentence = ""


class FilePiece(Message, frozen=True, kw_only=True, tag="file_piece"):
    """The bytes of the offered file from ``at`` on, with their CRC-32."""

    id: FileId
    at: Count
    check: Annotated[int, Meta(ge=0, lt=2**32)]
    data: Annotated[bytes, Meta(max_length=PIECE)]


class DeviceState(Message, frozen=True, kw_only=True, tag="device_state"):
    """Whether the gateway reaches a device. Sent on every change, and to a new link if it does not.

    While it does not, what the device last said is not true any more, however young it is.

    Attributes:
        why: why it is not reached.
        for_ms: not reached for so long.

    """

    device: Name
    reached: bool
    why: Sentence = ""
    for_ms: Millis = 0


class ArchiveOffer(Message, frozen=True, kw_only=True, tag="archive_offer"):
    """The gateway has a file for the hub's archive; answered and taken as a `FileOffer` is.

    Attributes:
        id: the gateway's own name for it, never used twice.
        kind: what it is and so where it goes: ``fits``.
        device: whose it is.
        digest: SHA-256 of the whole.
        time_us: when it was made.

    """

    id: FileId
    kind: Name
    device: Word = ""
    size: Count
    digest: Digest
    time_us: Micros = 0


# ── both ways ───────────────────────────────────────────────────────────────────────────────


class Beat(Message, frozen=True, kw_only=True, tag="beat"):
    """Are you there? Sent every second; three without a reply and the peer counts as gone."""

    n: Count
    mono_us: Micros


class BeatReply(Message, frozen=True, kw_only=True, tag="beat_reply"):
    """Yes. Echoes the beat and adds the answerer's monotonic clock, so clocks can be compared."""

    n: Count
    mono_us: Micros
    peer_us: Micros


class Bye(Message, frozen=True, kw_only=True, tag="bye"):
    """The link is closed on purpose.

    Attributes:
        reason: why.
        after_s: the hub has no place now, and asks to come back after so long; 0: it does not say.

    """

    reason: Sentence = ""
    after_s: Annotated[float, Meta(ge=0, le=3600)] = 0.0


# ── hub to gateway ──────────────────────────────────────────────────────────────────────────


class Welcome(Message, frozen=True, kw_only=True, tag="welcome"):
    """Answer to `Hello`.

    Attributes:
        acked: one past the last sequence number of this boot that is stored.
        takes: messages that may be sent to this hub, and not to older ones: ``enclosure``,
            ``newest``, ``seen``.

    """

    protocol: Count = PROTOCOL
    version: Sentence = ""
    acked: Count = 0
    time_us: Micros = 0
    takes: FormList = []


class Ack(Message, frozen=True, kw_only=True, tag="ack"):
    """Every sample of ``boot`` below sequence ``below`` is stored for good."""

    boot: Name
    below: Count


class Again(Message, frozen=True, kw_only=True, tag="again"):
    """Send samples ``first`` up to, not including, ``below`` of ``boot`` once more.

    The hub had no room for them (its database was away), so they are not stored; live samples go
    on meanwhile, and so do STOP and driving.
    """

    boot: Name
    first: Count
    below: Count


class LeaseAsk(Message, frozen=True, kw_only=True, tag="lease_ask"):
    """Take, renew or free the lease of a device for a session; ask for it, or answer an ask."""

    device: Name
    session: Name
    who: Name
    op: LeaseOp


class LeaseForce(Message, frozen=True, kw_only=True, tag="lease_force"):
    """Take the lease from its holder, who said no or nothing. The hub has seen to the right."""

    device: Name
    session: Name
    who: Name


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
    token: Word = ""


class CommandAsk(Message, frozen=True, kw_only=True, tag="command_ask"):
    """Do this once. The id is the asker's; an id is acted on at most once.

    Attributes:
        units: the unit that the asker was shown for each argument; another than the description
            has now is refused.
        over: the id of somebody else's command that is under way and may be interrupted by this.

    """

    id: Name
    device: Name
    command: Name
    args: Arguments = {}
    units: Units = {}
    ttl_ms: float
    who: Name
    over: Word = ""


class ChangeAsk(Message, frozen=True, kw_only=True, tag="change"):
    """Go by another description. The hub has seen to the right; the gateway judges for itself.

    Attributes:
        source: the text, deflated (zlib).
        base: SHA-256 of the text that it was made from, as the hub knows it.
        seal: HMAC-SHA256 under the SHA-256 of the gateway's key, see `wire.sealing`.

    """

    id: Name
    source: AskedText
    base: Digest
    who: Name
    seal: Digest


class CommandCancel(Message, frozen=True, kw_only=True, tag="command_cancel"):
    """End a command that is under way, if the robot can; its state tells what came of it."""

    id: Name
    device: Name
    who: Name


class OverrideAsk(Message, frozen=True, kw_only=True, tag="override"):
    """Override a condition of an interlock for so many seconds; 0 ends that.

    The hub has seen to the right.

    Attributes:
        condition: which, as `InterlockState` names it; empty for the one that locks.

    """

    interlock: Name
    who: Name
    reason: Sentence = ""
    seconds: Annotated[float, Meta(ge=0, le=86_400)]
    condition: Word = ""


class Watch(Message, frozen=True, kw_only=True, tag="watch"):
    """The streams (``device/stream``) that anyone looks at now; all others rest.

    Attributes:
        forms: by stream: what they are wanted as (`Form`); a stream that is not in it is wanted
            as JPEG, by a hub that knows nothing else.
        boxes: of which the `Boxes` are wanted, too.

    """

    streams: Annotated[list[Name], Meta(max_length=1000)]
    forms: Forms = {}
    boxes: Annotated[list[Name], Meta(max_length=1000)] = []


class KeyAsk(Message, frozen=True, kw_only=True, tag="key"):
    """Make the next picture of a stream, in this form, one that needs none before it."""

    stream: Name
    form: Word


class Reconnect(Message, frozen=True, kw_only=True, tag="reconnect"):
    """Connect anew to a device on the robot's side; an `Event` tells how it went.

    Driving and STOP are not touched by it.
    """

    device: Name
    who: Name


class RecordAsk(Message, frozen=True, kw_only=True, tag="record"):
    """Begin or end a recording of raw topics. The hub has seen to the right.

    Attributes:
        stream: only the film of this camera is meant.
        alarm: an alarm begins it, not a person: it goes on as long as one that began by itself,
            if the description wants that.

    """

    on: bool
    who: Name
    why: Sentence = ""
    alarm: bool = False
    stream: Name = ""


class FileHave(Message, frozen=True, kw_only=True, tag="file_have"):
    """How much of an offered file the hub has; the answer to each offer and piece.

    Attributes:
        have: bytes, from the beginning.
        done: all of it is there and its digest is right: the gateway may forget it.
        refused: why the hub does not take it; it is not offered again soon.

    """

    id: FileId
    have: Count = 0
    done: bool = False
    refused: Sentence = ""


class Picture(Message, frozen=True, kw_only=True, tag="picture"):
    """One picture of a stream, stamped at the gateway.

    Attributes:
        seq: the picture's number, the same in all forms; pictures may be left out.
        format: ``jpeg`` or ``h264`` (Annex B, no reordering).
        forms: which of the forms asked for this serves; none from a gateway that knows none.
        key: it needs no picture before it.
        codec: of ``h264``: as WebCodecs names it (``avc1.42C01E``).
        data: the encoded picture.

    """

    stream: Name
    seq: Count
    time_us: Micros
    mono_us: Micros
    width: Pixels
    height: Pixels
    format: Name = "jpeg"
    forms: FormList = []
    key: bool = True
    codec: Word = ""
    data: Annotated[bytes, Meta(max_length=MAX_PICTURE)]


class Trouble(Message, frozen=True, kw_only=True, tag="trouble"):
    """A camera's pictures cannot be shown, and why; sent once, only to a hub that names forms."""

    stream: Name
    why: Sentence


class Thing(Message, frozen=True, kw_only=True, tag="thing"):
    """One thing on a picture; places are parts of its width and height, from the upper left."""

    label: Name
    score: Share
    left: Share
    top: Share
    right: Share
    bottom: Share


class Boxes(Message, frozen=True, kw_only=True, tag="boxes"):
    """What is seen on one picture of a stream; sent only for those that `Watch` names.

    Attributes:
        seq: of the `Picture` that it was seen on.
        time_us: when that picture was taken.
        things: the surest first; also those that do not count (`talaia.model.detection.Detect`).

    """

    stream: Name
    seq: Count
    time_us: Micros
    things: Annotated[list[Thing], Meta(max_length=100)]


class Seen(Message, frozen=True, kw_only=True, tag="seen"):
    """Something of one class came into sight, is seen surer or more often, or is gone.

    On the link, to a hub that takes it (`Welcome`). ``stream``, ``label`` and ``began_us`` tell
    sightings apart; the same one may be told again, and what is told last counts.

    Attributes:
        many: how many at once, at the most so far.
        confidence: of the surest so far.
        began_us: when it was seen first.
        ended_us: when it was seen last; 0 while it is in sight.
        thumbnail: JPEG of a moment of it; empty while there is none, or as it was told before.

    """

    stream: Name
    label: Name
    many: Count
    confidence: Share
    began_us: Micros
    ended_us: Micros = 0
    thumbnail: Thumbnail = b""


FromGateway = (
    Hello
    | Samples
    | Newest
    | Gap
    | LeaseState
    | Tick
    | DriveState
    | StopState
    | ResetToken
    | CommandState
    | InterlockState
    | EnclosureState
    | RecordState
    | DeviceState
    | Described
    | ChangeState
    | Seen
    | Event
    | Beat
    | BeatReply
    | Bye
)
FromHub = (
    Welcome
    | Ack
    | Again
    | LeaseAsk
    | LeaseForce
    | Drive
    | StopAsk
    | ResetAsk
    | CommandAsk
    | ChangeAsk
    | CommandCancel
    | OverrideAsk
    | Watch
    | KeyAsk
    | Reconnect
    | RecordAsk
    | Beat
    | BeatReply
    | Bye
)
MediaFromGateway = Picture | Trouble | Boxes | Beat | BeatReply
MediaFromHub = Beat | BeatReply | Bye
FilesFromGateway = FileOffer | FilmOffer | ArchiveOffer | FilePiece
FilesFromHub = FileHave | Bye

LINK_FROM_GATEWAY: Codec[FromGateway] = Codec(FromGateway, 8 * 1024 * 1024)
LINK_FROM_HUB: Codec[FromHub] = Codec(FromHub, 1024 * 1024)
MEDIA_FROM_GATEWAY: Codec[MediaFromGateway] = Codec(MediaFromGateway, MAX_PICTURE)
MEDIA_FROM_HUB: Codec[MediaFromHub] = Codec(MediaFromHub, 64 * 1024)
FILES_FROM_GATEWAY: Codec[FilesFromGateway] = Codec(FilesFromGateway, 512 * 1024)
FILES_FROM_HUB: Codec[FilesFromHub] = Codec(FilesFromHub, 64 * 1024)
