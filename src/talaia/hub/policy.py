"""Who may do and see what: one line for every route and every message, both ways.

What has no line is denied. Needs are about an object (a site, or one of its devices) and are
checked for each message, after the object was looked up.

Routes stand in `talaia.hub.policy_routes`, messages here. Long, because each message has its line.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.auth.permissions import ANY, Right, sees_device, sees_site
from talaia.hub.policy_routes import (
    CLIENT_ROUTES,
    CLIENT_SOCKETS,
    ROUTES,
    ROUTES_OF,
    SOCKETS,
    AccessNeed,
)
from talaia.wire import browser, frames

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.hub.auth.permissions import Grants
    from talaia.model.site import Site
    from talaia.wire.message import Message

__all__ = [
    "BEFORE_FACTOR",
    "BY_DISPLAY",
    "BY_SCRIPT",
    "CLIENT_ROUTES",
    "CLIENT_SOCKETS",
    "CONFIRMED",
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


FROM_BROWSER: Mapping[type[Message], AccessNeed] = {
    # Each channel is looked at besides; what may not be seen is refused by name.
    browser.Subscribe: AccessNeed.SEE,
    browser.Unsubscribe: AccessNeed.SESSION,
    browser.PageLease: AccessNeed.USE,
    browser.PageLeaseForce: AccessNeed.ADMIN,
    browser.PageDrive: AccessNeed.USE,
    # The rights of the real device: it is what the twin may move.
    browser.PageTwin: AccessNeed.USE,
    browser.PageTwinDrive: AccessNeed.USE,
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
    browser.TopicShown: AccessNeed.SESSION,
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
    browser.TwinUpdate: AccessNeed.VIEW,
    browser.StopUpdate: AccessNeed.VIEW,
    browser.HeldStopUpdate: AccessNeed.VIEW,
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
    # Of the whole site; they name no target.
    browser.NightUpdate: AccessNeed.VIEW,
    browser.NightPlanUpdate: AccessNeed.VIEW,
    browser.ObservingRequestUpdate: AccessNeed.VIEW,
    browser.PagePong: AccessNeed.SESSION,
    browser.RequestError: AccessNeed.SESSION,
    # Of the session of that very socket.
    browser.SessionUpdate: AccessNeed.SESSION,
    browser.SessionEnded: AccessNeed.SESSION,
    # The stream was looked at when its socket was opened.
    browser.CameraPicture: AccessNeed.SESSION,
    browser.CameraPictureBoxes: AccessNeed.SESSION,
    browser.CameraPictureOverlay: AccessNeed.SESSION,
    # So was the topic, and it is again with each change of rights or of the description.
    browser.TopicUpdate: AccessNeed.SESSION,
    browser.TopicMessage: AccessNeed.SESSION,
    browser.TopicBytes: AccessNeed.SESSION,
}

# A gateway may say these about its own site, which its key names, and about no other.
FROM_GATEWAY: Mapping[type[Message], AccessNeed] = dict.fromkeys(
    (
        frames.Hello,
        frames.ResumeSaved,
        frames.SampleBatch,
        frames.NewestBatch,
        frames.SampleGap,
        frames.LeaseState,
        frames.ControlTick,
        frames.DriveState,
        frames.TwinState,
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
        frames.NightState,
        frames.NightPlan,
        frames.RequestRevision,
        frames.ObservationUpdate,
        frames.ReleaseState,
        frames.RobotLogBatch,
        # Who of the people gets such a file is looked up for each (`RobotAssets`).
        frames.AssetState,
        frames.Event,
        frames.Beat,
        frames.BeatReply,
        frames.Bye,
        frames.PictureFrame,
        frames.StreamError,
        frames.DetectedBoxes,
        frames.ModelOverlay,
        # Who of the takers gets what of these is looked up topic by topic (`may_tap`).
        frames.TopicList,
        frames.TapSchema,
        frames.TapMessage,
        frames.TapError,
        frames.RobotGraph,
        frames.FileOffer,
        frames.FilmOffer,
        frames.ArchiveOffer,
        frames.FilePiece,
        frames.ReleaseRequest,
    ),
    AccessNeed.GATEWAY,
)

TO_GATEWAY: Mapping[type[Message], AccessNeed] = dict.fromkeys(
    (
        frames.Welcome,
        frames.LinkHeld,
        frames.Ack,
        frames.ResendRequest,
        frames.LeaseRequest,
        frames.LeaseForceRequest,
        frames.DriveFrame,
        frames.TwinFrame,
        frames.TwinRequest,
        frames.StopRequest,
        frames.ResetRequest,
        frames.CommandRequest,
        frames.ChangeRequest,
        frames.CommandCancel,
        frames.OverrideRequest,
        frames.StreamSubscription,
        frames.KeyframeRequest,
        frames.TapSubscription,
        frames.SignalSubscription,
        frames.ReconnectRequest,
        frames.RecordingRequest,
        frames.NightArmRequest,
        frames.NightDisarmRequest,
        frames.RequestSync,
        frames.ObservationAck,
        frames.ReleaseOffer,
        frames.ReleasePiece,
        frames.RobotLogAck,
        frames.AssetRequest,
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
        # To approve and to arm is a person's decision.
        AccessNeed.REQUEST,
        AccessNeed.CLIENT,
    }
)

# What gives rights away: besides its need, the password (and the factor) was given anew a short
# while ago. No script can do that.
CONFIRMED = frozenset(
    {
        ("POST", "/api/me/tokens"),
        ("POST", "/api/displays"),
        ("POST", "/api/audit/hubs"),
        # What it has left here is proof, and goes with it.
        ("DELETE", "/api/audit/hubs/{hub}"),
        # Whoever finds a page open must not leave a key of their own behind.
        ("POST", "/api/me/passkeys"),
        ("POST", "/api/me/passkeys/options"),
        ("DELETE", "/api/me/passkeys/{passkey}"),
        ("POST", "/api/me/oidc/connect"),
        ("DELETE", "/api/me/oidc"),
        ("POST", "/api/people"),
        ("PATCH", "/api/people/{person}"),
        ("DELETE", "/api/people/{person}/factor"),
        ("POST", "/api/roles"),
        ("PUT", "/api/roles/{role}"),
        ("PUT", "/api/roles/{role}/factor"),
    }
)

# All that is open to a person whose role requires a second factor while they have none.
BEFORE_FACTOR = frozenset(
    {
        ("GET", "/api/me"),
        ("POST", "/api/logout"),
        ("POST", "/api/me/confirm"),
        ("POST", "/api/me/oidc/confirm"),
        ("POST", "/api/me/factor"),
        ("POST", "/api/me/factor/confirm"),
        ("GET", "/api/me/passkeys"),
        ("POST", "/api/me/passkeys"),
        ("POST", "/api/me/passkeys/options"),
    }
)

# What no script says over a page's socket, whatever its token may: it drives by its own, as a tool.
NOT_BY_SCRIPT = frozenset(
    {
        browser.PageLease,
        browser.PageLeaseForce,
        browser.PageDrive,
        browser.PageTwin,
        browser.PageTwinDrive,
        browser.PageReset,
    }
)

# All that a display says over a page's socket. It presses no STOP either: nobody knows who stands
# before it, and its address may be on a poster.
BY_DISPLAY = frozenset(
    {
        browser.Subscribe,
        browser.Unsubscribe,
        browser.PagePing,
        browser.PictureShown,
        browser.ViewerAttention,
        browser.BoxesRequest,
        browser.TopicShown,
    }
)

_RIGHT = {
    AccessNeed.VIEW: Right.VIEW,
    AccessNeed.USE: Right.USE,
    AccessNeed.ADMIN: Right.ADMIN,
    AccessNeed.REQUEST: Right.REQUEST,
    AccessNeed.APPROVE: Right.APPROVE,
    AccessNeed.ARM: Right.ARM,
    AccessNeed.UNBLURRED: Right.UNBLURRED,
}


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
