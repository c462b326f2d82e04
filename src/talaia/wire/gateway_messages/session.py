"""Messages of a link itself: handshake, heartbeat, devices in reach, events, the end."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.wire.gateway_messages.field_types import (
    Count,
    Deflated,
    FormList,
    Micros,
    Millis,
    Name,
    Sentence,
    Word,
)
from talaia.wire.gateway_messages.relayed_fields import EventFields
from talaia.wire.message import PROTOCOL, Message

__all__ = [
    "Beat",
    "BeatReply",
    "Bye",
    "DeviceState",
    "Event",
    "Hello",
    "LinkHeld",
    "ReconnectRequest",
    "ResumeSaved",
    "Welcome",
]


class Hello(Message, frozen=True, kw_only=True, tag="hello"):
    """First frame of a link.

    Attributes:
        boot: names this run of the gateway; sample sequences count from 0 in each.
        description: the site description as YAML text, the gateway's own copy.
        catalogue: names the channel list that `Samples.channel` indexes (see `Site.channels`).
        source: the text of the description's file as a person wrote it, deflated; empty where it
            is not from one file that may be changed.
        accepts: which changes the gateway takes from the hub: ``no``, ``readings`` or ``all``.
        acked: below which sample of this boot a hub has said that all is stored; -1: not said. A
            hub whose history is away answers with it.
        takes: messages that may be sent to this gateway, and not to older ones: ``asset_request``.

    """

    protocol: Count = PROTOCOL
    version: Sentence = ""
    site: Name
    boot: Name
    # As much as `yaml_text.load` reads.
    description: Annotated[str, Meta(max_length=4 * 1024 * 1024)]
    catalogue: Name
    # The gateway's wall clock as it says this: the hub tells by it how far the two are apart.
    time_us: Micros = 0
    source: Deflated = b""
    accepts: Word = ""
    acked: Annotated[int, Meta(ge=-1, le=2**62)] = -1
    takes: FormList = []


class Event(EventFields, frozen=True, kw_only=True, tag="event"):
    """Something worth writing down: adapter lost or back, drive started or ended, a refusal."""


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


class Beat(Message, frozen=True, kw_only=True, tag="beat"):
    """Are you there? Sent every second; three without a reply and the peer counts as gone."""

    # Rises; its reply has the same.
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


class Welcome(Message, frozen=True, kw_only=True, tag="welcome"):
    """Answer to `Hello`.

    Attributes:
        acked: one past the last sequence number of this boot that is stored.
        takes: messages that may be sent to this hub, and not to older ones: ``enclosure``,
            ``newest``, ``seen``, ``topic_list`` for all of raw topics, ``night_state`` for all of
            the night, ``robot_log``, and ``release_state`` for releases of the gateway's own
            software.
        resume: by this the gateway shows on its next link that it is the one of this: two numbers
            and a secret (hex), with dots between; empty where it has not proved its key by the
            hub's challenge.

    """

    protocol: Count = PROTOCOL
    version: Sentence = ""
    acked: Count = 0
    time_us: Micros = 0
    takes: FormList = []
    resume: Word = ""


class LinkHeld(Message, frozen=True, kw_only=True, tag="held"):
    """Answer to `Hello` in place of `Welcome`, which may follow: another gateway has the place.

    Only STOP and beats come meanwhile. Sent to gateways that prove their key by a challenge.

    Attributes:
        reason: why.

    """

    reason: Sentence = ""


class ResumeSaved(Message, frozen=True, kw_only=True, tag="resume_saved"):
    """What `Welcome.resume` handed down is on the gateway's disk; what was before is void.

    Attributes:
        serial: the second number of it.

    """

    serial: Count


class ReconnectRequest(Message, frozen=True, kw_only=True, tag="reconnect"):
    """Connect anew to a device on the robot's side; an `Event` tells how it went.

    Driving and STOP are not touched by it.
    """

    device: Name
    who: Name
