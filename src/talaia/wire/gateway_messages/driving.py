"""Leases, driving frames and STOP between gateway and hub."""

from __future__ import annotations

from enum import StrEnum

from talaia.wire.gateway_messages.field_types import (
    Count,
    JointSpeeds,
    Millis,
    Name,
    Sentence,
    Word,
)
from talaia.wire.gateway_messages.relayed_fields import DriveFields, StopFields, TickFields
from talaia.wire.message import Message

__all__ = [
    "ControlTick",
    "DriveFrame",
    "DriveState",
    "LeaseForceRequest",
    "LeaseOp",
    "LeaseRequest",
    "LeaseState",
    "ResetRequest",
    "ResetToken",
    "StopRequest",
    "StopState",
]


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


class LeaseState(Message, frozen=True, kw_only=True, tag="lease"):
    """Who holds a device. Sent on every change, and as the answer to each `LeaseRequest`.

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
    # Higher with each grant, also across restarts; a frame of a lower one is refused.
    epoch: Count = 0
    remains_ms: Millis = 0
    rival: Word = ""
    rival_who: Sentence = ""
    rival_ms: Millis = 0
    asked: Word = ""
    refused: Sentence = ""
    forceable: bool = False


class ControlTick(TickFields, frozen=True, kw_only=True, tag="tick"):
    """The gateway's own time mark, sent at 20 Hz while any lease is held; drivers echo it."""


class DriveState(DriveFields, frozen=True, kw_only=True, tag="drive_state"):
    """What the robot is being told: velocities (m/s, rad/s), speed cap (0 to 1), loop time.

    ``sent``: to a robot that is driven by characters, those since its last ``s``; its velocities
    are then what these add up to, and NaN where that is not described.
    """


class StopState(StopFields, frozen=True, kw_only=True, tag="stop_state"):
    """STOP (software): latched at the gateway; confirmed once the robot itself stands still."""


class ResetToken(Message, frozen=True, kw_only=True, tag="reset_token"):
    """The second step's key to a reset of STOP, for the session that asked."""

    device: Name
    session: Name
    token: Word = ""
    refused: Sentence = ""


class LeaseRequest(Message, frozen=True, kw_only=True, tag="lease_ask"):
    """Take, renew or free the lease of a device for a session; ask for it, or answer an ask."""

    device: Name
    session: Name
    who: Name
    op: LeaseOp


class LeaseForceRequest(Message, frozen=True, kw_only=True, tag="lease_force"):
    """Take the lease from its holder, who said no or nothing. The hub has seen to the right."""

    device: Name
    session: Name
    who: Name


class DriveFrame(Message, frozen=True, kw_only=True, tag="drive"):
    """A driving frame.

    Attributes:
        seq: rises with every frame of an epoch.
        tick: the newest `ControlTick` the driver's page has seen.
        held_ms: how long ago it saw it, by its own clock.
        ttl_ms: refuse this frame when it is older; 0 takes the description's.
        linear: forward (m/s). angular: counter-clockwise (rad/s), as in REP-103.
        lateral: to the left (m/s), of a base that moves sideways.
        steering: angle of the steered wheels, to the left (rad), of a vehicle that has them.
        joints: of each joint in the description's order (rad/s or m/s); none: all at rest.
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
    lateral: float = 0.0
    steering: float = 0.0
    joints: JointSpeeds = []
    picture_ms: float = -1.0

    @property
    def asks(self) -> bool:
        """Tell whether anything is asked for; else the driver has let go."""
        return any((self.linear, self.angular, self.lateral, self.steering, *self.joints))


class StopRequest(Message, frozen=True, kw_only=True, tag="stop_ask"):
    """STOP (software). Needs no lease. Repeated until a `StopState` with this id comes back."""

    device: Name
    id: Name
    who: Name


class ResetRequest(Message, frozen=True, kw_only=True, tag="reset_ask"):
    """Release STOP. Without ``token``: ask for one. With it: release. Needs the lease."""

    device: Name
    session: Name
    epoch: Count
    who: Name
    token: Word = ""
