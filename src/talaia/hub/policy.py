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
    "CLIENT_ROUTES",
    "CLIENT_SOCKETS",
    "FROM_BROWSER",
    "FROM_GATEWAY",
    "NOT_BY_SCRIPT",
    "ROUTES",
    "ROUTES_OF",
    "SOCKETS",
    "TO_BROWSER",
    "TO_GATEWAY",
    "AccessNeed",
    "allows",
    "need_of_message",
    "need_of_route",
]


class AccessNeed(Enum):
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
    # An access token, while an admin has opened the route's client protocol; cookies do not count.
    CLIENT = auto()
    # The key of a gateway.
    GATEWAY = auto()
    # Cannot be met.
    NEVER = auto()


# By the feature that brings the route (`talaia.hub.features`).
ROUTES_OF: Mapping[str, Mapping[tuple[str, str], AccessNeed]] = {
    "audit": {
        ("GET", "/api/audit"): AccessNeed.ADMIN,
        ("GET", "/api/audit/export"): AccessNeed.ADMIN,
        ("GET", "/api/audit/verify"): AccessNeed.ADMIN,
    },
    "gateways": {
        ("GET", "/api/gateways"): AccessNeed.ADMIN,
        ("POST", "/api/gateways/codes"): AccessNeed.ADMIN,
        ("DELETE", "/api/gateways/codes/{code}"): AccessNeed.ADMIN,
        ("POST", "/api/gateways/{gateway}/revoke"): AccessNeed.ADMIN,
        ("POST", "/api/gateways/{gateway}/reconnect"): AccessNeed.ADMIN,
        # Whoever has a code; it is one-time, short-lived, and tries are counted by address.
        ("POST", "/api/enrol"): AccessNeed.OPEN,
    },
    "people": {
        # Wrong tries are counted, and more of them must wait (`auth.throttle`).
        ("POST", "/api/login"): AccessNeed.OPEN,
        # Whoever has the token that the hub wrote at its start; it is used up by the first admin.
        ("POST", "/api/setup"): AccessNeed.OPEN,
        ("POST", "/api/logout"): AccessNeed.OWN,
        ("GET", "/api/me"): AccessNeed.SESSION,
        # A token that got out must not be able to take the account over.
        ("POST", "/api/me/password"): AccessNeed.OWN,
        ("GET", "/api/me/sessions"): AccessNeed.OWN,
        ("DELETE", "/api/me/sessions"): AccessNeed.OWN,
        ("DELETE", "/api/me/sessions/{session}"): AccessNeed.OWN,
        ("POST", "/api/me/factor"): AccessNeed.OWN,
        ("POST", "/api/me/factor/confirm"): AccessNeed.OWN,
        ("POST", "/api/me/factor/remove"): AccessNeed.OWN,
        ("GET", "/api/me/tokens"): AccessNeed.OWN,
        # A token must not outlive itself by making another.
        ("POST", "/api/me/tokens"): AccessNeed.OWN,
        ("DELETE", "/api/me/tokens/{token}"): AccessNeed.OWN,
        ("GET", "/api/people"): AccessNeed.ADMIN,
        ("POST", "/api/people"): AccessNeed.ADMIN,
        ("PATCH", "/api/people/{person}"): AccessNeed.ADMIN,
        ("DELETE", "/api/people/{person}"): AccessNeed.ADMIN,
        ("DELETE", "/api/people/{person}/sessions"): AccessNeed.ADMIN,
        ("DELETE", "/api/people/{person}/factor"): AccessNeed.ADMIN,
        ("GET", "/api/roles"): AccessNeed.ADMIN,
        ("POST", "/api/roles"): AccessNeed.ADMIN,
        ("PUT", "/api/roles/{role}"): AccessNeed.ADMIN,
        ("DELETE", "/api/roles/{role}"): AccessNeed.ADMIN,
    },
    "history": {
        # Each channel is looked at besides; what may not be seen is as if it were not there.
        ("GET", "/api/sites/{site}/history"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/last"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/statistics"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/outliers"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/stored"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/export"): AccessNeed.SEE,
    },
    "alarms": {
        # Each alarm's device is looked at besides; what may not be seen is as if it were not there.
        ("GET", "/api/sites/{site}/alarms"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/alarms/{alarm}/history"): AccessNeed.SEE,
        ("POST", "/api/sites/{site}/alarms/{alarm}/act"): AccessNeed.SEE,
        # Of the whole site: an alarm may look at any of its signals.
        ("POST", "/api/sites/{site}/alarm-preview"): AccessNeed.ADMIN,
        ("PUT", "/api/sites/{site}/alarms/{alarm}"): AccessNeed.ADMIN,
        ("DELETE", "/api/sites/{site}/alarms/{alarm}"): AccessNeed.ADMIN,
    },
    "notifications": {
        # Names and kinds only: a person chooses among them. What they are set to is an
        # admin's matter.
        ("GET", "/api/me/ways"): AccessNeed.OWN,
        ("GET", "/api/me/rules"): AccessNeed.OWN,
        ("POST", "/api/me/rules"): AccessNeed.OWN,
        ("PUT", "/api/me/rules/{rule}"): AccessNeed.OWN,
        ("DELETE", "/api/me/rules/{rule}"): AccessNeed.OWN,
        ("POST", "/api/me/rules/{rule}/test"): AccessNeed.OWN,
        ("GET", "/api/me/push"): AccessNeed.OWN,
        ("POST", "/api/me/push"): AccessNeed.OWN,
        ("DELETE", "/api/me/push/{browser}"): AccessNeed.OWN,
        ("GET", "/api/ways"): AccessNeed.ADMIN,
        ("POST", "/api/ways"): AccessNeed.ADMIN,
        ("PUT", "/api/ways/{way}"): AccessNeed.ADMIN,
        ("DELETE", "/api/ways/{way}"): AccessNeed.ADMIN,
        ("POST", "/api/ways/{way}/test"): AccessNeed.ADMIN,
    },
    "anomalies": {
        # Each signal is looked at besides; what may not be seen is as if it were not there.
        ("GET", "/api/sites/{site}/anomalies"): AccessNeed.SEE,
        ("POST", "/api/sites/{site}/anomalies/forgiven"): AccessNeed.USE,
    },
    "sightings": {
        # Each camera is looked at besides; what may not be seen is as if it were not there.
        ("GET", "/api/sites/{site}/sightings"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/sightings/labels"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/sightings/{sighting}/picture"): AccessNeed.SEE,
    },
    "archive": {
        # Names of stars and galaxies; nothing of the site.
        ("GET", "/api/sites/{site}/sky"): AccessNeed.SEE,
        # Each picture's camera is looked at besides; what may not be seen is as if it were
        # not there.
        ("GET", "/api/sites/{site}/frames"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/nights"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/frames/{frame}"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/frames/{frame}/file"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/frames/{frame}/preview"): AccessNeed.SEE,
    },
    "recordings": {
        # Of the whole site: raw topics hold what no single device's right opens.
        ("GET", "/api/sites/{site}/recordings"): AccessNeed.VIEW,
        ("GET", "/api/sites/{site}/recordings/{recording}/file"): AccessNeed.VIEW,
        ("POST", "/api/sites/{site}/recordings"): AccessNeed.USE,
        ("DELETE", "/api/sites/{site}/recordings/{recording}"): AccessNeed.ADMIN,
        # Each film's camera is looked at besides; what may not be seen is as if it were not there.
        ("GET", "/api/sites/{site}/films"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/films/{recording}/file"): AccessNeed.SEE,
    },
    "taps": {
        # Each topic is looked at besides; what may not be tapped is as if it were not there.
        ("GET", "/api/sites/{site}/topics"): AccessNeed.SEE,
    },
    "descriptions": {
        # Of the whole site: a description holds all that is there, and how it is reached.
        ("GET", "/api/sites/{site}/descriptions"): AccessNeed.ADMIN,
        ("GET", "/api/sites/{site}/descriptions/{number}"): AccessNeed.ADMIN,
        ("GET", "/api/sites/{site}/descriptions/{number}/difference"): AccessNeed.ADMIN,
        ("POST", "/api/sites/{site}/descriptions"): AccessNeed.ADMIN,
        ("POST", "/api/sites/{site}/descriptions/check"): AccessNeed.ADMIN,
        ("POST", "/api/sites/{site}/descriptions/edit"): AccessNeed.ADMIN,
        ("POST", "/api/sites/{site}/descriptions/{number}/restore"): AccessNeed.ADMIN,
        ("GET", "/api/description-schema"): AccessNeed.SESSION,
    },
    "extensions": {
        ("GET", "/api/extensions"): AccessNeed.ADMIN,
        # What is broken, and why, only an admin is given.
        ("GET", "/api/tiles"): AccessNeed.SESSION,
        ("GET", "/extensions/{tile}/{path:path}"): AccessNeed.SESSION,
    },
    "metrics": {
        # The right `metrics` is asked for besides, site by site, and each signal is looked at.
        ("GET", "/metrics"): AccessNeed.CLIENT,
        ("POST", "/clients/prometheus/read"): AccessNeed.CLIENT,
    },
    "socketio": {
        # The site is looked at besides, as for the socket below.
        ("GET", "/socket.io/"): AccessNeed.CLIENT,
        ("POST", "/socket.io/"): AccessNeed.CLIENT,
    },
    "client_protocols": {
        ("GET", "/api/client-protocols"): AccessNeed.ADMIN,
        ("PUT", "/api/client-protocols/{protocol}"): AccessNeed.ADMIN,
        ("PUT", "/api/client-drivers"): AccessNeed.ADMIN,
    },
    "storage": {
        ("GET", "/api/storage"): AccessNeed.ADMIN,
        ("GET", "/api/storage/outlook"): AccessNeed.ADMIN,
    },
    "pages": {
        # For whoever watches the hub from outside, without an account.
        ("GET", "/api/health"): AccessNeed.OPEN,
        ("GET", "/api/openapi.json"): AccessNeed.ADMIN,
        # Lists what is open to the person, and no more.
        ("GET", "/api/devices"): AccessNeed.SESSION,
        ("GET", "/api/sites"): AccessNeed.SESSION,
        ("GET", "/api/sites/{site}"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/events"): AccessNeed.SEE,
        # The pages' own files, before anybody is signed in; they hold nothing of a site.
        ("GET", "/{path:path}"): AccessNeed.OPEN,
    },
}

# Method and path as the route has it, with its placeholders.
ROUTES: Mapping[tuple[str, str], AccessNeed] = {
    route: need for lines in ROUTES_OF.values() for route, need in lines.items()
}

# Asked at the upgrade; what is said over them is looked up message by message below.
SOCKETS: Mapping[str, AccessNeed] = {
    "/ws": AccessNeed.SESSION,
    "/ws/media": AccessNeed.SEE,
    "/gateway/link": AccessNeed.GATEWAY,
    "/gateway/media": AccessNeed.GATEWAY,
    "/gateway/files": AccessNeed.GATEWAY,
}

# Which client protocol (`clients.catalog`) an admin has to have opened for a route.
CLIENT_ROUTES: Mapping[str, str] = {
    "/metrics": "metrics",
    "/clients/prometheus/read": "metrics",
    "/socket.io/": "socketio",
}

# Of other tools, while an admin has opened their protocol, by token alone; each message over them
# is looked up in the tables below, like a page's.
CLIENT_SOCKETS: Mapping[str, AccessNeed] = {
    "/clients/foxglove/{site}": AccessNeed.SEE,
    "/clients/rosbridge/{site}": AccessNeed.SEE,
    "/clients/scripts/{site}": AccessNeed.SEE,
    "/socket.io/": AccessNeed.SEE,
}

FROM_BROWSER: Mapping[type[Message], AccessNeed] = {
    # Each channel is looked at besides; what may not be seen is refused by name.
    browser.Subscribe: AccessNeed.SEE,
    browser.Unsubscribe: AccessNeed.SESSION,
    browser.PageLease: AccessNeed.USE,
    browser.PageLeaseForce: AccessNeed.ADMIN,
    browser.PageDrive: AccessNeed.USE,
    # Whoever may look at a device may stop it.
    browser.PageStop: AccessNeed.VIEW,
    browser.PageReset: AccessNeed.USE,
    browser.PageCommand: AccessNeed.USE,
    browser.PageCommandCancel: AccessNeed.USE,
    # Of the whole site: an interlock guards more than one device.
    browser.PageOverride: AccessNeed.ADMIN,
    browser.PagePing: AccessNeed.SESSION,
    browser.PictureShown: AccessNeed.SESSION,
    browser.ViewerAttention: AccessNeed.SESSION,
    browser.BoxesRequest: AccessNeed.SESSION,
}

TO_BROWSER: Mapping[type[Message], AccessNeed] = {
    browser.Greeting: AccessNeed.SESSION,
    browser.SiteUpdate: AccessNeed.SEE,
    browser.Subscribed: AccessNeed.SESSION,
    # Holds only channels that the subscription was granted.
    browser.Values: AccessNeed.SESSION,
    browser.LeaseUpdate: AccessNeed.VIEW,
    # Told to the holder of a lease only, and says no more than a number.
    browser.TickUpdate: AccessNeed.SEE,
    browser.DriveUpdate: AccessNeed.VIEW,
    browser.StopUpdate: AccessNeed.VIEW,
    browser.ResetTokenUpdate: AccessNeed.USE,
    browser.CommandUpdate: AccessNeed.VIEW,
    # Whoever sees a site knows why nothing moves there; names only the devices they may see.
    browser.InterlockUpdate: AccessNeed.SEE,
    browser.DeviceUpdate: AccessNeed.VIEW,
    # Of the whole site where an alarm is about more than one device.
    browser.AlarmUpdate: AccessNeed.VIEW,
    # The camera is looked at besides: told to those who may see its pictures.
    browser.SightingUpdate: AccessNeed.SEE,
    # The signal is looked at besides: one that is public may be of a device that is not.
    browser.AnomalyUpdate: AccessNeed.SEE,
    browser.EventUpdate: AccessNeed.VIEW,
    browser.PagePong: AccessNeed.SESSION,
    browser.RequestError: AccessNeed.SESSION,
    # Of the session of that very socket.
    browser.SessionUpdate: AccessNeed.SESSION,
    browser.SessionEnded: AccessNeed.SESSION,
    # The stream was looked at when its socket was opened.
    browser.CameraPicture: AccessNeed.SESSION,
    browser.CameraPictureBoxes: AccessNeed.SESSION,
}

# A gateway may say these about its own site, which its key names, and about no other.
FROM_GATEWAY: Mapping[type[Message], AccessNeed] = dict.fromkeys(
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
        # Who of the takers gets what of these is looked up topic by topic (`may_tap`).
        frames.TopicList,
        frames.TapSchema,
        frames.TapMessage,
        frames.TapError,
        frames.FileOffer,
        frames.FilmOffer,
        frames.ArchiveOffer,
        frames.FilePiece,
    ),
    AccessNeed.GATEWAY,
)

TO_GATEWAY: Mapping[type[Message], AccessNeed] = dict.fromkeys(
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
        frames.TapSubscription,
        frames.ReconnectRequest,
        frames.RecordingRequest,
        frames.FileProgress,
        frames.Beat,
        frames.BeatReply,
        frames.Bye,
    ),
    AccessNeed.GATEWAY,
)

# What a token may be used for; the rest a person must do.
BY_SCRIPT = frozenset(
    {
        AccessNeed.OPEN,
        AccessNeed.SESSION,
        AccessNeed.SEE,
        AccessNeed.VIEW,
        AccessNeed.USE,
        AccessNeed.CLIENT,
    }
)

# What no script says over a page's socket, whatever its token may: it drives by its own, as a tool.
NOT_BY_SCRIPT = frozenset(
    {browser.PageLease, browser.PageLeaseForce, browser.PageDrive, browser.PageReset}
)

_RIGHT = {AccessNeed.VIEW: Right.VIEW, AccessNeed.USE: Right.USE, AccessNeed.ADMIN: Right.ADMIN}


def need_of_route(method: str, path: str) -> AccessNeed:
    """Give what a route takes; ``path`` is the route's own, with its placeholders."""
    # HEAD is answered like GET without the body, so it takes the same.
    return ROUTES.get(("GET" if method == "HEAD" else method, path), AccessNeed.NEVER)


def need_of_message(table: Mapping[type[Message], AccessNeed], message: Message) -> AccessNeed:
    """Give what a message takes, by one of the tables above."""
    return table.get(type(message), AccessNeed.NEVER)


def allows(
    need: AccessNeed, grants: Grants | None, site: Site | None = None, device: str = ""
) -> bool:
    """Tell whether a person meets a need.

    Args:
        need: what it takes, by the table.
        grants: the person's; None when nobody is signed in.
        site: the site it is about; None when it is about none, or there is no such site.
        device: the device it is about; empty when it is about the whole site.

    """
    if need is AccessNeed.OPEN:
        return True
    # No person is a gateway, whatever rights they have.
    # Nor are clients' tokens asked for here: that is where their protocols are known.
    if grants is None or need in {AccessNeed.NEVER, AccessNeed.GATEWAY, AccessNeed.CLIENT}:
        return False
    if need in {AccessNeed.SESSION, AccessNeed.OWN}:
        return True
    # Of the whole hub, or of a site that nobody knows: it takes the right on every site.
    if need is AccessNeed.ADMIN and site is None:
        return grants.has_right(Right.ADMIN, ANY)
    # What is not there is open to nobody, so that a refusal does not tell the two apart.
    if site is None or (device and device not in site.devices):
        return False
    if need is AccessNeed.SEE:
        return sees_device(grants, site, device) if device else sees_site(grants, site)
    return grants.has_right(_RIGHT[need], site.site, device or ANY)
