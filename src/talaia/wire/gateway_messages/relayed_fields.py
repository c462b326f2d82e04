"""Fields of a gateway's messages that the hub repeats to pages, with the site beside them.

What both say stands here once. A gateway's message adds what only the hub may know; a page's adds
``site``. Sessions are never among them: one page must not learn another's.
"""

from __future__ import annotations

from enum import StrEnum

from talaia.wire.gateway_messages.field_types import Count, Micros, Name, Sentence, Word
from talaia.wire.message import Message

__all__ = [
    "CommandFields",
    "CommandPhase",
    "DriveFields",
    "EventFields",
    "StopFields",
    "TickFields",
]


class CommandPhase(StrEnum):
    """Where a one-shot command stands. The last five are final."""

    ACCEPTED = "accepted"
    RUNNING = "running"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    REFUSED = "refused"
    CANCELLED = "cancelled"
    UNKNOWN = "unknown"


class TickFields(Message, frozen=True, kw_only=True):
    """The gateway's own time mark, which drivers echo."""

    tick: Count


class DriveFields(Message, frozen=True, kw_only=True):
    """What the robot is being told: velocities (m/s, rad/s), speed cap (0 to 1), loop time."""

    device: Name
    linear: float
    angular: float
    cap: float
    loop_ms: float = 0.0
    accepted: Count = 0
    refused: Count = 0
    why: Sentence = ""
    sent: Word = ""


class StopFields(Message, frozen=True, kw_only=True):
    """STOP (software): latched at the gateway; confirmed once the robot itself stands still."""

    device: Name
    latched: bool
    confirmed: bool = False
    who: Sentence = ""
    time_us: Micros = 0
    id: Word = ""


class CommandFields(Message, frozen=True, kw_only=True):
    """Where a one-shot command stands, in the robot's own words where it gave any."""

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


class EventFields(Message, frozen=True, kw_only=True):
    """Something worth writing down."""

    kind: Name
    device: Word = ""
    message: Sentence = ""
    who: Sentence = ""
    time_us: Micros = 0
    good: bool = True
