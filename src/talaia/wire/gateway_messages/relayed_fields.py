"""Fields of a gateway's messages that the hub repeats to pages, with the site beside them.

What both say stands here once. A gateway's message adds what only the hub may know; a page's adds
``site``. Sessions are never among them: one page must not learn another's.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from msgspec import Meta

from talaia.wire.gateway_messages.field_types import (
    Count,
    JointSpeeds,
    Micros,
    Name,
    Sentence,
    Word,
)
from talaia.wire.message import Message

__all__ = [
    "CommandFields",
    "CommandPhase",
    "DriveFields",
    "EventFields",
    "NightFields",
    "NightPhase",
    "StopFields",
    "TickFields",
]


_UnixSeconds = Annotated[float, Meta(ge=0, le=2**34)]


class CommandPhase(StrEnum):
    """Where a one-shot command stands. The last five are final."""

    ACCEPTED = "accepted"
    RUNNING = "running"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    REFUSED = "refused"
    CANCELLED = "cancelled"
    # It may have been done and it may not: whoever asked has to look.
    UNKNOWN = "unknown"


class TickFields(Message, frozen=True, kw_only=True):
    """The gateway's own time mark, which drivers echo."""

    tick: Count


class DriveFields(Message, frozen=True, kw_only=True):
    """What the robot is being told: velocities (m/s, rad/s), speed cap (0 to 1), loop time."""

    device: Name
    linear: float
    angular: float
    lateral: float = 0.0
    # Angle of the steered wheels (rad).
    steering: float = 0.0
    # Of each joint, in the description's order (rad/s or m/s).
    joints: JointSpeeds = []
    # What part of the limits may be driven now; it falls with the loop time.
    cap: float
    loop_ms: float = 0.0
    # Frames since this drive began.
    accepted: Count = 0
    # Since the last drive ended; frames that began no drive count as well.
    refused: Count = 0
    # Why the last frame was refused; empty when it was accepted.
    why: Sentence = ""
    sent: Word = ""


class StopFields(Message, frozen=True, kw_only=True):
    """STOP (software): latched at the gateway; confirmed once the robot itself stands still."""

    device: Name
    latched: bool
    confirmed: bool = False
    who: Sentence = ""
    # When it was latched (UTC).
    time_us: Micros = 0
    # Of the `StopRequest` that this answers, or else of the one that latched it.
    id: Word = ""


class CommandFields(Message, frozen=True, kw_only=True):
    """Where a one-shot command stands, in the robot's own words where it gave any."""

    id: Name
    device: Name
    command: Name
    phase: CommandPhase
    message: Sentence = ""
    # 0 to 1, and never falling.
    progress: float = 0.0
    who: Sentence = ""
    blocked_by: Word = ""
    acting: Sentence = ""
    acting_s: float = 0.0


class EventFields(Message, frozen=True, kw_only=True):
    """Something worth writing down."""

    kind: Name
    device: Word = ""
    message: Sentence = ""
    who: Sentence = ""
    time_us: Micros = 0
    # False for what went wrong or was refused.
    good: bool = True


class NightPhase(StrEnum):
    """What the executor of a night does."""

    DISARMED = "disarmed"
    # Armed, and the Sun is too high.
    WAITING = "waiting"
    OPENING = "opening"
    OBSERVING = "observing"
    # Armed, and a condition keeps the roof closed.
    CLOSED = "closed"
    CALIBRATING = "calibrating"
    PARKING = "parking"
    # A device failed, and a person is called; nothing goes on by itself.
    FAULT = "fault"


class NightFields(Message, frozen=True, kw_only=True):
    """How a night stands, in words that name no target: whoever may view the site reads them.

    Attributes:
        phase: see `NightPhase`.
        armed_by: who; empty: nobody.
        armed_until: (s since the epoch, UTC); 0: until disarmed, or not armed.
        why: why it waits, is closed or failed, in words.
        since: of the phase (s since the epoch, UTC).
        request: which is observed; empty: none.
        step: of its block, in words: *slewing*, *centring*, *exposing*.
        frames_done: of the request that is observed.
        frames: of it in all.
        site_time: of a simulated site that lives faster than people do: what time it is there (s
            since the epoch, UTC); 0: the time is everybody's.
        speed: so many times as fast it lives while the night is armed; 0: as everybody.

    """

    phase: NightPhase
    armed_by: Word = ""
    armed_until: _UnixSeconds = 0.0
    why: Sentence = ""
    since: _UnixSeconds = 0.0
    request: Word = ""
    step: Word = ""
    frames_done: Count = 0
    frames: Count = 0
    site_time: _UnixSeconds = 0.0
    speed: Annotated[float, Meta(ge=0, le=1e6)] = 0.0
