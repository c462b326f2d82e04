"""Messages from a page to the hub."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from talaia.wire.browser_messages.subjects import DeviceMessage, SessionMessage, SiteMessage
from talaia.wire.gateway_messages.driving import LeaseOp
from talaia.wire.gateway_messages.field_types import (
    Arguments,
    Count,
    JointSpeeds,
    Name,
    Units,
    Word,
)
from talaia.wire.gateway_messages.twins import TwinOp

__all__ = [
    "PageCommand",
    "PageCommandCancel",
    "PageDrive",
    "PageLease",
    "PageLeaseForce",
    "PageOverride",
    "PagePing",
    "PageReset",
    "PageStop",
    "PageTwin",
    "PageTwinDrive",
    "Subscribe",
    "Unsubscribe",
]


class Subscribe(SiteMessage, frozen=True, kw_only=True, tag="subscribe"):
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


class Unsubscribe(SessionMessage, frozen=True, kw_only=True, tag="unsubscribe"):
    """No more of this subscription."""

    sub: Count


class PageLease(DeviceMessage, frozen=True, kw_only=True, tag="lease"):
    """Take, renew or free the lease of a device; ask its holder for it, or answer an ask."""

    site: Name
    device: Name
    op: LeaseOp


class PageLeaseForce(DeviceMessage, frozen=True, kw_only=True, tag="lease_force"):
    """Take the lease from its holder, who said no or nothing to your ask."""

    site: Name
    device: Name


class PageDrive(DeviceMessage, frozen=True, kw_only=True, tag="drive"):
    """A driving frame; the fields are those of `frames.DriveFrame`."""

    site: Name
    device: Name
    # Of the lease: a frame that its holder before sent is refused.
    epoch: Count
    seq: Count
    tick: Count
    held_ms: float = 0.0
    linear: float
    angular: float
    lateral: float = 0.0
    steering: float = 0.0
    joints: JointSpeeds = []
    picture_ms: float = -1.0


class PageTwin(DeviceMessage, frozen=True, kw_only=True, tag="twin_ask"):
    """Switch the twin of a device live or alone, or forget its rehearsal; needs the lease."""

    site: Name
    device: Name
    epoch: Count
    op: TwinOp


class PageTwinDrive(DeviceMessage, frozen=True, kw_only=True, tag="twin_drive"):
    """What is driven in the twin of a device; see `frames.TwinFrame`."""

    site: Name
    device: Name
    epoch: Count
    seq: Count
    tick: Count
    held_ms: float = 0.0
    linear: float
    angular: float
    picture_ms: float = -1.0
    live: bool = False


class PageStop(DeviceMessage, frozen=True, kw_only=True, tag="stop"):
    """STOP (software). Repeat with the same id until `StopUpdate` with it comes."""

    site: Name
    device: Name
    id: Name


class PageReset(DeviceMessage, frozen=True, kw_only=True, tag="reset"):
    """Release STOP: first without a token, then with the one that `ResetTokenUpdate` brought."""

    site: Name
    device: Name
    # Of the lease that the asker holds: nobody else may release STOP.
    epoch: Count
    token: Word = ""


class PageCommand(DeviceMessage, frozen=True, kw_only=True, tag="command"):
    """Ask a device to do something once. ``id`` is the page's own, never used twice.

    ``units`` are those the page showed beside the arguments, and ``over`` is somebody else's
    command that the person was shown and wants to interrupt; see `frames.CommandRequest`.
    """

    site: Name
    device: Name
    command: Name
    id: Name
    args: Arguments = {}
    units: Units = {}
    over: Word = ""


class PageCommandCancel(DeviceMessage, frozen=True, kw_only=True, tag="cancel"):
    """End a command that is under way, if the robot can; `CommandUpdate` tells what came of it."""

    site: Name
    device: Name
    id: Name


class PageOverride(SiteMessage, frozen=True, kw_only=True, tag="override"):
    """Override a condition of an interlock for so many seconds, with the reason; 0 s ends that.

    Attributes:
        condition: which, as `InterlockUpdate` names it; empty for the one that locks.

    """

    site: Name
    interlock: Name
    reason: Annotated[str, Meta(max_length=500)] = ""
    # The wire's own bound; the gateway refuses more than `LONGEST_OVERRIDE_S`, half an hour.
    seconds: Annotated[float, Meta(ge=0, le=86_400)]
    condition: Word = ""


class PagePing(SessionMessage, frozen=True, kw_only=True, tag="ping"):
    """Every second.

    Attributes:
        at_ms: the page's own clock, handed back in `PagePong`.
        active: a person has touched the page since the last one; that keeps the session.

    """

    n: Count
    at_ms: float
    active: bool = False
