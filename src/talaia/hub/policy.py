"""Who may do and see what: one line for every route and every message, both ways.

What has no line is denied. Needs are about an object (a site, or one of its devices) and are
checked for each message, after the object was looked up.
"""

from __future__ import annotations

from enum import Enum, auto
from typing import TYPE_CHECKING

from talaia.hub.auth.permissions import ANY, Right, sees_device, sees_site
from talaia.wire import browser, frames

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.hub.auth.permissions import Grants
    from talaia.model.site import Site
    from talaia.wire.shape import Message

__all__ = [
    "FROM_BROWSER",
    "FROM_GATEWAY",
    "ROUTES",
    "SOCKETS",
    "TO_BROWSER",
    "TO_GATEWAY",
    "Need",
    "allows",
    "need_of_message",
    "need_of_route",
]


class Need(Enum):
    """What it takes."""

    # Nothing: nobody has to be signed in.
    OPEN = auto()
    # To be signed in.
    SESSION = auto()
    # That the object, or something of it, is public or open to the person.
    SEE = auto()
    # The right on the device; on the whole site where the message names no device.
    VIEW = auto()
    USE = auto()
    ADMIN = auto()
    # The key of a gateway.
    GATEWAY = auto()
    # Cannot be met.
    NEVER = auto()


ROUTES: Mapping[tuple[str, str], Need] = {
    ("GET", "/api/health"): Need.OPEN,
    ("POST", "/api/login"): Need.OPEN,
    ("POST", "/api/setup"): Need.OPEN,
    ("POST", "/api/logout"): Need.SESSION,
    ("GET", "/api/me"): Need.SESSION,
    ("GET", "/api/sites"): Need.SESSION,
    ("GET", "/api/sites/{site}"): Need.SEE,
    ("GET", "/api/sites/{site}/history"): Need.SEE,
    ("GET", "/api/sites/{site}/events"): Need.SEE,
    ("GET", "/{path:path}"): Need.OPEN,
}

SOCKETS: Mapping[str, Need] = {
    "/ws": Need.SESSION,
    "/ws/media": Need.SEE,
    "/gateway/link": Need.GATEWAY,
    "/gateway/media": Need.GATEWAY,
}

FROM_BROWSER: Mapping[type[Message], Need] = {
    # Each channel is looked at besides; what may not be seen is refused by name.
    browser.Subscribe: Need.SEE,
    browser.Unsubscribe: Need.SESSION,
    browser.Lease: Need.USE,
    browser.LeaseForce: Need.ADMIN,
    browser.Drive: Need.USE,
    # Whoever may look at a device may stop it.
    browser.Stop: Need.VIEW,
    browser.Reset: Need.USE,
    browser.Command: Need.USE,
    browser.Cancel: Need.USE,
    # Of the whole site: an interlock guards more than one device.
    browser.Override: Need.ADMIN,
    browser.Ping: Need.SESSION,
    browser.Shown: Need.SESSION,
}

TO_BROWSER: Mapping[type[Message], Need] = {
    browser.Greeting: Need.SESSION,
    browser.SiteNews: Need.SEE,
    browser.Subscribed: Need.SESSION,
    # Holds only channels that the subscription was granted.
    browser.Values: Need.SESSION,
    browser.LeaseNews: Need.VIEW,
    # Told to the holder of a lease only, and says no more than a number.
    browser.TickNews: Need.SEE,
    browser.DriveNews: Need.VIEW,
    browser.StopNews: Need.VIEW,
    browser.ResetKey: Need.USE,
    browser.CommandNews: Need.VIEW,
    # Whoever sees a site knows why nothing moves there; names only the devices they may see.
    browser.InterlockNews: Need.SEE,
    browser.EventNews: Need.VIEW,
    browser.Pong: Need.SESSION,
    browser.Problem: Need.SESSION,
    browser.Ended: Need.SESSION,
    # The stream was looked at when its socket was opened.
    browser.Shot: Need.SESSION,
}

FROM_GATEWAY: Mapping[type[Message], Need] = dict.fromkeys(
    (
        frames.Hello,
        frames.Samples,
        frames.Gap,
        frames.LeaseState,
        frames.Tick,
        frames.DriveState,
        frames.StopState,
        frames.ResetToken,
        frames.CommandState,
        frames.InterlockState,
        frames.Event,
        frames.Beat,
        frames.BeatReply,
        frames.Bye,
        frames.Picture,
    ),
    Need.GATEWAY,
)

TO_GATEWAY: Mapping[type[Message], Need] = dict.fromkeys(
    (
        frames.Welcome,
        frames.Ack,
        frames.LeaseAsk,
        frames.LeaseForce,
        frames.Drive,
        frames.StopAsk,
        frames.ResetAsk,
        frames.CommandAsk,
        frames.CommandCancel,
        frames.OverrideAsk,
        frames.Watch,
        frames.Beat,
        frames.BeatReply,
        frames.Bye,
    ),
    Need.GATEWAY,
)

_RIGHT = {Need.VIEW: Right.VIEW, Need.USE: Right.USE, Need.ADMIN: Right.ADMIN}


def need_of_route(method: str, path: str) -> Need:
    """Give what a route takes; ``path`` is the route's own, with its placeholders."""
    return ROUTES.get(("GET" if method == "HEAD" else method, path), Need.NEVER)


def need_of_message(table: Mapping[type[Message], Need], message: Message) -> Need:
    """Give what a message takes, by one of the tables above."""
    return table.get(type(message), Need.NEVER)


def allows(need: Need, grants: Grants | None, site: Site | None = None, device: str = "") -> bool:
    """Tell whether a person meets a need.

    Args:
        need: what it takes, by the table.
        grants: the person's; None when nobody is signed in.
        site: the site it is about; None when it is about none, or there is no such site.
        device: the device it is about; empty when it is about the whole site.

    """
    if need is Need.OPEN:
        return True
    if grants is None or need in {Need.NEVER, Need.GATEWAY}:
        return False
    if need is Need.SESSION:
        return True
    if need is Need.ADMIN and site is None:
        return grants.may(Right.ADMIN, ANY)
    if site is None or (device and device not in site.devices):
        return False
    if need is Need.SEE:
        return sees_device(grants, site, device) if device else sees_site(grants, site)
    return grants.may(_RIGHT[need], site.site, device or ANY)
