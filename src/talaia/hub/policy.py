"""Who may do and see what: one line for every route and every message, both ways.

What has no line is denied. Needs are about an object (a site, or one of its devices) and are
checked for each message, after the object was looked up.

Long, because all routes and messages are to be found in one list.
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
    from talaia.wire.message import Message

__all__ = [
    "BY_SCRIPT",
    "FROM_BROWSER",
    "FROM_GATEWAY",
    "ROUTES",
    "ROUTES_OF",
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
    # To be signed in oneself; a script with a token of one's is not.
    OWN = auto()
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


# By the feature that brings the route (`talaia.hub.features`).
ROUTES_OF: Mapping[str, Mapping[tuple[str, str], Need]] = {
    "audit": {
        ("GET", "/api/audit"): Need.ADMIN,
        ("GET", "/api/audit/export"): Need.ADMIN,
        ("GET", "/api/audit/verify"): Need.ADMIN,
    },
    "gateways": {
        ("GET", "/api/gateways"): Need.ADMIN,
        ("POST", "/api/gateways/codes"): Need.ADMIN,
        ("DELETE", "/api/gateways/codes/{code}"): Need.ADMIN,
        ("POST", "/api/gateways/{gateway}/revoke"): Need.ADMIN,
        ("POST", "/api/gateways/{gateway}/reconnect"): Need.ADMIN,
        # Whoever has a code; it is one-time, short-lived, and tries are counted by address.
        ("POST", "/api/enrol"): Need.OPEN,
    },
    "people": {
        ("POST", "/api/login"): Need.OPEN,
        ("POST", "/api/setup"): Need.OPEN,
        ("POST", "/api/logout"): Need.OWN,
        ("GET", "/api/me"): Need.SESSION,
        ("POST", "/api/me/password"): Need.OWN,
        ("GET", "/api/me/sessions"): Need.OWN,
        ("DELETE", "/api/me/sessions"): Need.OWN,
        ("DELETE", "/api/me/sessions/{session}"): Need.OWN,
        ("POST", "/api/me/factor"): Need.OWN,
        ("POST", "/api/me/factor/confirm"): Need.OWN,
        ("POST", "/api/me/factor/remove"): Need.OWN,
        ("GET", "/api/me/tokens"): Need.OWN,
        ("POST", "/api/me/tokens"): Need.OWN,
        ("DELETE", "/api/me/tokens/{token}"): Need.OWN,
        ("GET", "/api/people"): Need.ADMIN,
        ("POST", "/api/people"): Need.ADMIN,
        ("PATCH", "/api/people/{person}"): Need.ADMIN,
        ("DELETE", "/api/people/{person}"): Need.ADMIN,
        ("DELETE", "/api/people/{person}/sessions"): Need.ADMIN,
        ("DELETE", "/api/people/{person}/factor"): Need.ADMIN,
        ("GET", "/api/roles"): Need.ADMIN,
        ("POST", "/api/roles"): Need.ADMIN,
        ("PUT", "/api/roles/{role}"): Need.ADMIN,
        ("DELETE", "/api/roles/{role}"): Need.ADMIN,
    },
    "history": {
        # Each channel is looked at besides; what may not be seen is as if it were not there.
        ("GET", "/api/sites/{site}/history"): Need.SEE,
        ("GET", "/api/sites/{site}/last"): Need.SEE,
        ("GET", "/api/sites/{site}/statistics"): Need.SEE,
        ("GET", "/api/sites/{site}/outliers"): Need.SEE,
        ("GET", "/api/sites/{site}/stored"): Need.SEE,
        ("GET", "/api/sites/{site}/export"): Need.SEE,
    },
    "alarms": {
        # Each alarm's device is looked at besides; what may not be seen is as if it were not there.
        ("GET", "/api/sites/{site}/alarms"): Need.SEE,
        ("GET", "/api/sites/{site}/alarms/{alarm}/history"): Need.SEE,
        ("POST", "/api/sites/{site}/alarms/{alarm}/act"): Need.SEE,
        # Of the whole site: an alarm may look at any of its signals.
        ("POST", "/api/sites/{site}/alarm-preview"): Need.ADMIN,
        ("PUT", "/api/sites/{site}/alarms/{alarm}"): Need.ADMIN,
        ("DELETE", "/api/sites/{site}/alarms/{alarm}"): Need.ADMIN,
    },
    "notifications": {
        # Names and kinds only: a person chooses among them. What they are set to is an
        # admin's matter.
        ("GET", "/api/me/ways"): Need.OWN,
        ("GET", "/api/me/rules"): Need.OWN,
        ("POST", "/api/me/rules"): Need.OWN,
        ("PUT", "/api/me/rules/{rule}"): Need.OWN,
        ("DELETE", "/api/me/rules/{rule}"): Need.OWN,
        ("POST", "/api/me/rules/{rule}/test"): Need.OWN,
        ("GET", "/api/me/push"): Need.OWN,
        ("POST", "/api/me/push"): Need.OWN,
        ("DELETE", "/api/me/push/{browser}"): Need.OWN,
        ("GET", "/api/ways"): Need.ADMIN,
        ("POST", "/api/ways"): Need.ADMIN,
        ("PUT", "/api/ways/{way}"): Need.ADMIN,
        ("DELETE", "/api/ways/{way}"): Need.ADMIN,
        ("POST", "/api/ways/{way}/test"): Need.ADMIN,
    },
    "anomalies": {
        # Each signal is looked at besides; what may not be seen is as if it were not there.
        ("GET", "/api/sites/{site}/anomalies"): Need.SEE,
        ("POST", "/api/sites/{site}/anomalies/forgiven"): Need.USE,
    },
    "sightings": {
        # Each camera is looked at besides; what may not be seen is as if it were not there.
        ("GET", "/api/sites/{site}/sightings"): Need.SEE,
        ("GET", "/api/sites/{site}/sightings/labels"): Need.SEE,
        ("GET", "/api/sites/{site}/sightings/{sighting}/picture"): Need.SEE,
    },
    "archive": {
        # Names of stars and galaxies; nothing of the site.
        ("GET", "/api/sites/{site}/sky"): Need.SEE,
        # Each picture's camera is looked at besides; what may not be seen is as if it were
        # not there.
        ("GET", "/api/sites/{site}/frames"): Need.SEE,
        ("GET", "/api/sites/{site}/nights"): Need.SEE,
        ("GET", "/api/sites/{site}/frames/{frame}"): Need.SEE,
        ("GET", "/api/sites/{site}/frames/{frame}/file"): Need.SEE,
        ("GET", "/api/sites/{site}/frames/{frame}/preview"): Need.SEE,
    },
    "recordings": {
        # Of the whole site: raw topics hold what no single device's right opens.
        ("GET", "/api/sites/{site}/recordings"): Need.VIEW,
        ("GET", "/api/sites/{site}/recordings/{recording}/file"): Need.VIEW,
        ("POST", "/api/sites/{site}/recordings"): Need.USE,
        ("DELETE", "/api/sites/{site}/recordings/{recording}"): Need.ADMIN,
        # Each film's camera is looked at besides; what may not be seen is as if it were not there.
        ("GET", "/api/sites/{site}/films"): Need.SEE,
        ("GET", "/api/sites/{site}/films/{recording}/file"): Need.SEE,
    },
    "descriptions": {
        # Of the whole site: a description holds all that is there, and how it is reached.
        ("GET", "/api/sites/{site}/descriptions"): Need.ADMIN,
        ("GET", "/api/sites/{site}/descriptions/{number}"): Need.ADMIN,
        ("GET", "/api/sites/{site}/descriptions/{number}/difference"): Need.ADMIN,
        ("POST", "/api/sites/{site}/descriptions"): Need.ADMIN,
        ("POST", "/api/sites/{site}/descriptions/check"): Need.ADMIN,
        ("POST", "/api/sites/{site}/descriptions/edit"): Need.ADMIN,
        ("POST", "/api/sites/{site}/descriptions/{number}/restore"): Need.ADMIN,
        ("GET", "/api/description-schema"): Need.SESSION,
    },
    "extensions": {
        ("GET", "/api/extensions"): Need.ADMIN,
    },
    "storage": {
        ("GET", "/api/storage"): Need.ADMIN,
        ("GET", "/api/storage/outlook"): Need.ADMIN,
    },
    "pages": {
        ("GET", "/api/health"): Need.OPEN,
        ("GET", "/api/openapi.json"): Need.ADMIN,
        # Lists what is open to the person, and no more.
        ("GET", "/api/devices"): Need.SESSION,
        ("GET", "/api/sites"): Need.SESSION,
        ("GET", "/api/sites/{site}"): Need.SEE,
        ("GET", "/api/sites/{site}/events"): Need.SEE,
        ("GET", "/{path:path}"): Need.OPEN,
    },
}

ROUTES: Mapping[tuple[str, str], Need] = {
    route: need for lines in ROUTES_OF.values() for route, need in lines.items()
}

SOCKETS: Mapping[str, Need] = {
    "/ws": Need.SESSION,
    "/ws/media": Need.SEE,
    "/gateway/link": Need.GATEWAY,
    "/gateway/media": Need.GATEWAY,
    "/gateway/files": Need.GATEWAY,
}

FROM_BROWSER: Mapping[type[Message], Need] = {
    # Each channel is looked at besides; what may not be seen is refused by name.
    browser.Subscribe: Need.SEE,
    browser.Unsubscribe: Need.SESSION,
    browser.PageLease: Need.USE,
    browser.PageLeaseForce: Need.ADMIN,
    browser.PageDrive: Need.USE,
    # Whoever may look at a device may stop it.
    browser.PageStop: Need.VIEW,
    browser.PageReset: Need.USE,
    browser.PageCommand: Need.USE,
    browser.PageCommandCancel: Need.USE,
    # Of the whole site: an interlock guards more than one device.
    browser.PageOverride: Need.ADMIN,
    browser.PagePing: Need.SESSION,
    browser.PictureShown: Need.SESSION,
    browser.ViewerAttention: Need.SESSION,
    browser.BoxesRequest: Need.SESSION,
}

TO_BROWSER: Mapping[type[Message], Need] = {
    browser.Greeting: Need.SESSION,
    browser.SiteUpdate: Need.SEE,
    browser.Subscribed: Need.SESSION,
    # Holds only channels that the subscription was granted.
    browser.Values: Need.SESSION,
    browser.LeaseUpdate: Need.VIEW,
    # Told to the holder of a lease only, and says no more than a number.
    browser.TickUpdate: Need.SEE,
    browser.DriveUpdate: Need.VIEW,
    browser.StopUpdate: Need.VIEW,
    browser.ResetTokenUpdate: Need.USE,
    browser.CommandUpdate: Need.VIEW,
    # Whoever sees a site knows why nothing moves there; names only the devices they may see.
    browser.InterlockUpdate: Need.SEE,
    browser.DeviceUpdate: Need.VIEW,
    # Of the whole site where an alarm is about more than one device.
    browser.AlarmUpdate: Need.VIEW,
    # The camera is looked at besides: told to those who may see its pictures.
    browser.SightingUpdate: Need.SEE,
    # The signal is looked at besides: one that is public may be of a device that is not.
    browser.AnomalyUpdate: Need.SEE,
    browser.EventUpdate: Need.VIEW,
    browser.PagePong: Need.SESSION,
    browser.RequestError: Need.SESSION,
    # Of the session of that very socket.
    browser.SessionUpdate: Need.SESSION,
    browser.SessionEnded: Need.SESSION,
    # The stream was looked at when its socket was opened.
    browser.CameraPicture: Need.SESSION,
    browser.CameraPictureBoxes: Need.SESSION,
}

FROM_GATEWAY: Mapping[type[Message], Need] = dict.fromkeys(
    (
        frames.Hello,
        frames.SampleBatch,
        frames.NewestBatch,
        frames.SampleGap,
        frames.LeaseState,
        frames.ControlTick,
        frames.DriveState,
        frames.StopState,
        frames.ResetToken,
        frames.CommandState,
        frames.InterlockState,
        frames.EnclosureState,
        frames.RecorderState,
        frames.DeviceState,
        frames.DescriptionUpdate,
        frames.ChangeState,
        frames.SightingReport,
        frames.Event,
        frames.Beat,
        frames.BeatReply,
        frames.Bye,
        frames.PictureFrame,
        frames.StreamError,
        frames.DetectedBoxes,
        frames.FileOffer,
        frames.FilmOffer,
        frames.ArchiveOffer,
        frames.FilePiece,
    ),
    Need.GATEWAY,
)

TO_GATEWAY: Mapping[type[Message], Need] = dict.fromkeys(
    (
        frames.Welcome,
        frames.Ack,
        frames.ResendRequest,
        frames.LeaseRequest,
        frames.LeaseForceRequest,
        frames.DriveFrame,
        frames.StopRequest,
        frames.ResetRequest,
        frames.CommandRequest,
        frames.ChangeRequest,
        frames.CommandCancel,
        frames.OverrideRequest,
        frames.StreamSubscription,
        frames.KeyframeRequest,
        frames.ReconnectRequest,
        frames.RecordingRequest,
        frames.FileProgress,
        frames.Beat,
        frames.BeatReply,
        frames.Bye,
    ),
    Need.GATEWAY,
)

# What a token may be used for; the rest a person must do.
BY_SCRIPT = frozenset({Need.OPEN, Need.SESSION, Need.SEE, Need.VIEW, Need.USE})

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
    if need in {Need.SESSION, Need.OWN}:
        return True
    if need is Need.ADMIN and site is None:
        return grants.may(Right.ADMIN, ANY)
    if site is None or (device and device not in site.devices):
        return False
    if need is Need.SEE:
        return sees_device(grants, site, device) if device else sees_site(grants, site)
    return grants.may(_RIGHT[need], site.site, device or ANY)
