"""Which words of a gateway stand in the log, and of what it may speak. Pure."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from msgspec.structs import replace

from talaia.wire import frames

if TYPE_CHECKING:
    from talaia.hub.live.gateways.handed_down import HandedDown
    from talaia.hub.live.gateways.robot_events import RobotMessage
    from talaia.hub.live.sites import LiveSite

__all__ = ["event_words", "is_described", "with_known_names", "with_known_who"]

# What the hub writes itself has no underscore in its kind.
_OWN_KIND = re.compile(r"[a-z0-9]+(_[a-z0-9]+)+", re.ASCII)
# And what gateways have always said without one.
_OLD_KINDS = frozenset(
    {
        "camera",
        "camera back",
        "connection back",
        "connection lost",
        "detection back",
        "detection lost",
        "device not reconnected",
        "device reconnected",
        "unreadable",
    }
)
_STRANGE_KIND = "gateway event"


def event_words(kind: str, message: str) -> tuple[str, str]:
    """Give the kind and the message of an event as they are written down.

    A kind that could be the hub's own, such as *login*, is none of a gateway's: it stands in the
    message.
    """
    if kind in _OLD_KINDS or _OWN_KIND.fullmatch(kind):
        return kind, message
    return _STRANGE_KIND, f"{kind}: {message}"


def is_described(live: LiveSite, told: frames.FromGateway) -> bool:
    """Tell whether what a message is about is in the description."""
    site = live.description
    match told:
        case frames.InterlockState():
            return told.interlock in site.interlocks
        case frames.EnclosureState():
            return told.enclosure in site.enclosures
        # The end of a command that was asked for is told, whatever became of its device.
        case frames.CommandState():
            return told.device in site.devices or live.handed_down.asker_of(told.id) is not None
        case (
            frames.LeaseState()
            | frames.DriveState()
            | frames.TwinState()
            | frames.StopState()
            | frames.ResetToken()
            | frames.DeviceState()
        ):
            return told.device in site.devices
        case frames.Event():
            return not told.device or told.device in site.devices
        case _:
            return True


def with_known_names(live: LiveSite, told: RobotMessage) -> RobotMessage:
    """Mark names that the hub never handed down, so that nobody takes them for an account's."""
    known = live.handed_down
    match told:
        case frames.LeaseState():
            holder = known.asker_of(told.session) if told.session else None
            rival = known.asker_of(told.rival) if told.rival else None
            return replace(
                told,
                who=known.known_name(told.who) if holder is None else holder,
                rival_who=known.known_name(told.rival_who) if rival is None else rival,
            )
        case frames.StopState() | frames.TwinState() | frames.CommandState() | frames.Event():
            return replace(told, who=known.known_name(told.who))
        case frames.InterlockState():
            return replace(told, overridden_by=known.known_name(told.overridden_by))
        case _:
            return told


def with_known_who(
    known: HandedDown, offer: frames.FileOffer | frames.FilmOffer
) -> frames.FileOffer | frames.FilmOffer:
    """Mark who a recording is said to be asked for by, where the hub never handed them down."""
    return replace(offer, who=known.known_name(offer.who))
