"""Messages from the hub to a page: values, and how devices and sessions stand.

Long, because a page takes them as one closed list.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.wire.browser_messages.subjects import DeviceMessage, SessionMessage, SiteMessage
from talaia.wire.columns import MAX_SAMPLES
from talaia.wire.gateway_messages.field_types import (
    ChannelColumn,
    Count,
    Micros,
    Millis,
    Name,
    OffsetColumn,
    Sentence,
    Texts,
    ValueColumn,
    Word,
)
from talaia.wire.gateway_messages.relayed_fields import (
    CommandFields,
    DriveFields,
    EventFields,
    StopFields,
    TickFields,
)
from talaia.wire.gateway_messages.twins import TwinFields
from talaia.wire.message import PROTOCOL

__all__ = [
    "CommandUpdate",
    "DeviceUpdate",
    "DriveUpdate",
    "EventUpdate",
    "Greeting",
    "HeldStopUpdate",
    "InterlockUpdate",
    "LeaseUpdate",
    "PagePong",
    "RequestError",
    "ResetTokenUpdate",
    "SessionEnded",
    "SessionUpdate",
    "SiteUpdate",
    "StopUpdate",
    "Subscribed",
    "TickUpdate",
    "TwinUpdate",
    "Values",
]


class Greeting(SessionMessage, frozen=True, kw_only=True, tag="greeting"):
    """First frame: who the hub takes you for."""

    protocol: Count = PROTOCOL
    # Of the hub, for people; what is understood goes by `protocol`.
    version: Word = ""
    who: Word
    role: Word
    # The hub's clock as it greets (UTC).
    time_us: Micros


class SiteUpdate(SiteMessage, frozen=True, kw_only=True, tag="site"):
    """A site's link came up or went down, or its description changed (``catalogue``).

    Attributes:
        rival_us: another gateway with this one's key was there then (UTC) and is kept out; 0 when
            none has been for two minutes.
        away: of several hubs the one that has it cannot be reached: nothing is known of it now,
            neither its gateway nor its alarms.

    """

    site: Word
    online: bool
    # Online or offline since then (UTC).
    since_us: Micros
    # Another one than before: the description has changed, and a page asks for it anew.
    catalogue: Word = ""
    # Hub to gateway and back, by the last beat.
    loop_ms: float = 0.0
    # How far the gateway's wall clock is ahead of the hub's.
    skew_ms: float = 0.0
    # Why it is away; empty while it is connected.
    why: Sentence = ""
    rival_us: Micros = 0
    away: bool = False


class Subscribed(SessionMessage, frozen=True, kw_only=True, tag="subscribed"):
    """Answer to `Subscribe`. Channels you may not see, or that are not there, are refused."""

    sub: Count
    refused: Annotated[list[Name], Meta(max_length=10_000)] = []


class Values(SessionMessage, frozen=True, kw_only=True, tag="values"):
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


class LeaseUpdate(DeviceMessage, frozen=True, kw_only=True, tag="lease_news"):
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
    # The lease ends after so long unless it is renewed.
    remains_ms: Millis = 0
    rival: Word = ""
    asking: bool = False
    answer_ms: Millis = 0
    refused: Sentence = ""
    forceable: bool = False


class TickUpdate(TickFields, SiteMessage, frozen=True, kw_only=True, tag="tick"):
    """The gateway's newest time mark; echo it in `PageDrive`."""

    site: Word


class DriveUpdate(DriveFields, DeviceMessage, frozen=True, kw_only=True, tag="drive_news"):
    """What the robot is being told; see `frames.DriveState`."""

    site: Word


class TwinUpdate(TwinFields, DeviceMessage, frozen=True, kw_only=True, tag="twin_news"):
    """How a twin's switch stands, and its rehearsal; see `frames.TwinState`."""

    site: Word


class StopUpdate(StopFields, DeviceMessage, frozen=True, kw_only=True, tag="stop_news"):
    """STOP (software): see `frames.StopState`."""

    site: Word


class HeldStopUpdate(DeviceMessage, frozen=True, kw_only=True, tag="held_stop_news"):
    """How far a STOP got at other gateways with the key of the one that is linked, which wait.

    What they say is their own word: one of them may be a thief.

    Attributes:
        id: of the newest press that was sent to them.
        held: how many wait and were sent it; 0: none does any more.
        latched: how many of them say that it is latched.
        confirmed: how many say that the robot stands still.

    """

    site: Word
    device: Word
    id: Word = ""
    held: Count = 0
    latched: Count = 0
    confirmed: Count = 0


class ResetTokenUpdate(DeviceMessage, frozen=True, kw_only=True, tag="reset_key"):
    """The token for the second step of a reset, or why there is none."""

    site: Word
    device: Word
    token: Word = ""
    refused: Sentence = ""


class CommandUpdate(CommandFields, DeviceMessage, frozen=True, kw_only=True, tag="command_news"):
    """Where a one-shot command stands; ``blocked_by`` as in `frames.CommandState`.

    A page that comes while somebody acts is told of that first.

    Attributes:
        acting: who acts on the device by it, and on what, in words; empty: nobody, or no longer.
        acting_s: for how long already (s).

    """

    site: Word


class InterlockUpdate(SiteMessage, frozen=True, kw_only=True, tag="interlock_news"):
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
        unknown: the conditions of which nothing is known now, as `InterlockState` names them.

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
    unknown: Annotated[list[Sentence], Meta(max_length=1000)] = []


class DeviceUpdate(DeviceMessage, frozen=True, kw_only=True, tag="device_news"):
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


class EventUpdate(EventFields, DeviceMessage, frozen=True, kw_only=True, tag="event"):
    """Something happened at a site that people should know of."""

    site: Word


class PagePong(SessionMessage, frozen=True, kw_only=True, tag="pong"):
    """Answer to `PagePing`, with the hub's monotonic clock (µs) so that ages can be told."""

    n: Count
    at_ms: float
    hub_us: Micros


class RequestError(SessionMessage, frozen=True, kw_only=True, tag="problem"):
    """What you asked was not done, and why.

    Attributes:
        code: ``forbidden``, ``unknown``, ``offline``, ``invalid``, ``busy``, or ``store`` when
            the hub cannot tell who may do it, since its database does not answer.
        about: the tag of the message this answers.

    """

    code: Word
    message: Sentence
    about: Word = ""


class SessionUpdate(SessionMessage, frozen=True, kw_only=True, tag="session"):
    """Your session ends soon; said in good time, so that a driver can stop and hand over.

    Attributes:
        ends_us: when (UTC, µs); 0 when it goes on after all.
        idle: touching the page keeps it; otherwise it ends then whatever you do: sign in again.

    """

    ends_us: Micros
    idle: bool = False


class SessionEnded(SessionMessage, frozen=True, kw_only=True, tag="ended"):
    """Your session is over; the socket closes after this."""

    reason: Sentence
