"""Digital twins between gateway and hub: what drives them, and what a rehearsal came to.

What is driven in a twin is no `DriveFrame` with a field more: whoever does not know these kinds
passes them over, and nothing moves; an unknown field would be passed over and the robot driven.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from msgspec import Meta

from talaia.wire.gateway_messages.field_types import Count, Name, Sentence
from talaia.wire.message import Message

__all__ = [
    "MOST_POSES",
    "MOST_VERDICTS",
    "RehearsalVerdict",
    "TwinFields",
    "TwinFrame",
    "TwinOp",
    "TwinRequest",
    "TwinState",
]

MOST_POSES = 200
MOST_VERDICTS = 50


class TwinOp(StrEnum):
    """What is asked of a twin's switch."""

    # What is driven in the twin goes to the robot, which the twin follows.
    LIVE = "live"
    # It does not.
    ALONE = "alone"
    # Forget the rehearsal's path.
    CLEAR = "clear"


class RehearsalVerdict(Message, frozen=True, kw_only=True, tag="verdict"):
    """What the gateway would have said of driving the robot, from a pose of the rehearsal on.

    Attributes:
        at: place of the pose in the path.
        why: the reason it would have refused; empty: it would not.
        share: of its limits that the robot might have been driven at, 0 to 1.

    """

    at: Count
    why: Sentence = ""
    share: float = 1.0


# x, y and heading of one pose after the other.
_Poses = Annotated[list[float], Meta(max_length=3 * MOST_POSES)]
_Verdicts = Annotated[list[RehearsalVerdict], Meta(max_length=MOST_VERDICTS)]


class TwinFields(Message, frozen=True, kw_only=True):
    """How a twin's switch stands, and its rehearsal.

    Attributes:
        device: the real one.
        twin: the twin's device.
        live: what is driven in the twin goes to the robot.
        who: has switched it on; empty while it is off.
        why: why it is off, or why the last frame was refused; empty when all is well.
        path: of the rehearsal: x, y (m) and heading (rad) of one pose after the other, in the
            robot's odometry frame, the newest last.
        metres: that it was driven.
        seconds: since it began.
        verdicts: each where it changed, in order of the path.

    """

    device: Name
    twin: Name
    live: bool = False
    who: Sentence = ""
    why: Sentence = ""
    path: _Poses = []
    metres: float = 0.0
    seconds: float = 0.0
    verdicts: _Verdicts = []


class TwinState(TwinFields, frozen=True, kw_only=True, tag="twin"):
    """See `TwinFields`. Sent on every change, at most five times a second."""


class TwinRequest(Message, frozen=True, kw_only=True, tag="twin_ask"):
    """Switch a twin live or alone, or forget its rehearsal. Needs the lease of ``device``."""

    device: Name
    session: Name
    epoch: Count
    who: Name
    op: TwinOp


class TwinFrame(Message, frozen=True, kw_only=True, tag="twin_drive"):
    """What is driven in the twin of ``device``; fields as in `DriveFrame`.

    Attributes:
        live: it is meant for the robot as well. Refused unless the gateway has the twin live.

    """

    device: Name
    session: Name
    epoch: Count
    seq: Count
    tick: Count
    held_ms: float = 0.0
    linear: float
    angular: float
    picture_ms: float = -1.0
    live: bool = False
