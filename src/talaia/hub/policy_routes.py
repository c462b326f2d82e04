"""What every route of the hub takes: one line for each.

What has no line is denied; `talaia.hub.policy` judges by it. Long, because each has its line.
"""

from __future__ import annotations

from enum import Enum, auto
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["CLIENT_ROUTES", "CLIENT_SOCKETS", "ROUTES", "ROUTES_OF", "SOCKETS", "AccessNeed"]


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
    # The right of that name on the whole site; see `Right`.
    REQUEST = auto()
    APPROVE = auto()
    ARM = auto()
    # The right on the device whose camera it is.
    UNBLURRED = auto()
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
        ("GET", "/api/audit/hubs"): AccessNeed.ADMIN,
        ("POST", "/api/audit/hubs"): AccessNeed.ADMIN,
        ("DELETE", "/api/audit/hubs/{hub}"): AccessNeed.ADMIN,
        ("GET", "/api/audit/hubs/{hub}/heads"): AccessNeed.ADMIN,
        # Whoever has another hub's token; tries are counted by address, and its key must fit.
        ("POST", "/api/heads"): AccessNeed.OPEN,
    },
    "gateways": {
        ("GET", "/api/gateways"): AccessNeed.ADMIN,
        ("POST", "/api/gateways/codes"): AccessNeed.ADMIN,
        ("DELETE", "/api/gateways/codes/{code}"): AccessNeed.ADMIN,
        ("POST", "/api/gateways/{gateway}/revoke"): AccessNeed.ADMIN,
        ("POST", "/api/gateways/{gateway}/reconnect"): AccessNeed.ADMIN,
        ("POST", "/api/gateways/{gateway}/second"): AccessNeed.ADMIN,
        # Whoever has a code; it is one-time, short-lived, and tries are counted by address.
        ("POST", "/api/enrol"): AccessNeed.OPEN,
    },
    "people": {
        # Wrong tries are counted, and more of them must wait (`auth.throttle`).
        ("POST", "/api/login"): AccessNeed.OPEN,
        # The same; and each challenge is good once.
        ("POST", "/api/login/passkey"): AccessNeed.OPEN,
        ("POST", "/api/login/passkey/options"): AccessNeed.OPEN,
        # Which provider there is; to begin; and to come back, with what the provider has said.
        ("GET", "/api/login/oidc"): AccessNeed.OPEN,
        ("POST", "/api/login/oidc"): AccessNeed.OPEN,
        ("POST", "/api/login/oidc/finish"): AccessNeed.OPEN,
        ("POST", "/api/me/oidc/confirm"): AccessNeed.OWN,
        ("POST", "/api/me/oidc/connect"): AccessNeed.OWN,
        ("GET", "/api/me/oidc"): AccessNeed.OWN,
        ("DELETE", "/api/me/oidc"): AccessNeed.OWN,
        # Whoever has the token that the hub wrote at its start; it is used up by the first admin.
        ("POST", "/api/setup"): AccessNeed.OPEN,
        ("POST", "/api/logout"): AccessNeed.OWN,
        # The password is in it, and wrong tries are counted as those of a sign-in.
        ("POST", "/api/me/confirm"): AccessNeed.OWN,
        ("GET", "/api/me"): AccessNeed.SESSION,
        # A token that got out must not be able to take the account over.
        ("POST", "/api/me/password"): AccessNeed.OWN,
        ("GET", "/api/me/sessions"): AccessNeed.OWN,
        ("DELETE", "/api/me/sessions"): AccessNeed.OWN,
        ("DELETE", "/api/me/sessions/{session}"): AccessNeed.OWN,
        ("POST", "/api/me/factor"): AccessNeed.OWN,
        ("POST", "/api/me/factor/confirm"): AccessNeed.OWN,
        ("POST", "/api/me/factor/remove"): AccessNeed.OWN,
        ("POST", "/api/me/factor/seen"): AccessNeed.OWN,
        ("GET", "/api/me/passkeys"): AccessNeed.OWN,
        ("POST", "/api/me/passkeys"): AccessNeed.OWN,
        ("POST", "/api/me/passkeys/options"): AccessNeed.OWN,
        # To confirm by one that is there already; it gives nothing away.
        ("POST", "/api/me/passkeys/challenge"): AccessNeed.OWN,
        ("PATCH", "/api/me/passkeys/{passkey}"): AccessNeed.OWN,
        ("DELETE", "/api/me/passkeys/{passkey}"): AccessNeed.OWN,
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
        ("DELETE", "/api/people/{person}/oidc"): AccessNeed.ADMIN,
        ("GET", "/api/displays"): AccessNeed.ADMIN,
        ("POST", "/api/displays"): AccessNeed.ADMIN,
        ("DELETE", "/api/displays/{display}"): AccessNeed.ADMIN,
        # Whoever has a display's token; tries are counted by address.
        ("POST", "/api/displays/open"): AccessNeed.OPEN,
        ("GET", "/api/roles"): AccessNeed.ADMIN,
        ("POST", "/api/roles"): AccessNeed.ADMIN,
        ("PUT", "/api/roles/{role}"): AccessNeed.ADMIN,
        ("DELETE", "/api/roles/{role}"): AccessNeed.ADMIN,
        ("PUT", "/api/roles/{role}/factor"): AccessNeed.ADMIN,
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
        ("POST", "/api/sites/{site}/anomalies/confirmed"): AccessNeed.USE,
        ("POST", "/api/sites/{site}/anomalies/learned"): AccessNeed.USE,
        # Each detector is looked at besides.
        ("GET", "/api/sites/{site}/causes"): AccessNeed.SEE,
        ("POST", "/api/sites/{site}/causes/known"): AccessNeed.USE,
        ("DELETE", "/api/sites/{site}/causes/known/{known}"): AccessNeed.USE,
        ("GET", "/api/sites/{site}/anomalies/budget"): AccessNeed.SEE,
        ("PUT", "/api/sites/{site}/anomalies/budget"): AccessNeed.USE,
        # They compute at the hub for minutes; each signal is looked at besides.
        ("POST", "/api/sites/{site}/anomalies/tests"): AccessNeed.USE,
        ("GET", "/api/sites/{site}/anomalies/tests/{test}"): AccessNeed.USE,
        ("DELETE", "/api/sites/{site}/anomalies/tests/{test}"): AccessNeed.USE,
    },
    "sightings": {
        # Each camera is looked at besides; what may not be seen is as if it were not there.
        ("GET", "/api/sites/{site}/sightings"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/sightings/labels"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/sightings/days"): AccessNeed.SEE,
        # A person's own marks; nobody else's change by it.
        ("POST", "/api/sites/{site}/sightings/seen"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/sightings/{sighting}/picture"): AccessNeed.SEE,
    },
    "archive": {
        # Names of stars and galaxies; nothing of the site.
        ("GET", "/api/sites/{site}/sky"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/sky/field"): AccessNeed.SEE,
        # Each picture's camera is looked at besides; what may not be seen is as if it were
        # not there.
        ("GET", "/api/sites/{site}/frames"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/nights"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/frames/{frame}"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/frames/{frame}/file"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/frames/{frame}/preview"): AccessNeed.SEE,
    },
    "observing": {
        # Each proposal is looked at besides (decision 0090); what may not be seen is as if it
        # were not there.
        ("GET", "/api/sites/{site}/proposals"): AccessNeed.SEE,
        ("POST", "/api/sites/{site}/proposals"): AccessNeed.ADMIN,
        ("PUT", "/api/sites/{site}/proposals/{proposal}"): AccessNeed.ADMIN,
        ("DELETE", "/api/sites/{site}/proposals/{proposal}"): AccessNeed.ADMIN,
        ("PUT", "/api/sites/{site}/proposals/{proposal}/members"): AccessNeed.ADMIN,
        ("GET", "/api/sites/{site}/requests"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/requests/{number}"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/request-groups/{group}"): AccessNeed.SEE,
        # To be a member of the proposal is asked for besides.
        ("POST", "/api/sites/{site}/request-groups"): AccessNeed.REQUEST,
        ("PUT", "/api/sites/{site}/request-groups/{group}"): AccessNeed.REQUEST,
        ("POST", "/api/sites/{site}/request-groups/{group}/clone"): AccessNeed.REQUEST,
        ("POST", "/api/sites/{site}/request-groups/{group}/submit"): AccessNeed.REQUEST,
        # Nothing is kept by these.
        ("POST", "/api/sites/{site}/request-groups/validate"): AccessNeed.REQUEST,
        ("POST", "/api/sites/{site}/request-groups/import"): AccessNeed.REQUEST,
        # By whoever asked for it, leads its proposal, or approves.
        ("POST", "/api/sites/{site}/request-groups/{group}/withdraw"): AccessNeed.SEE,
        ("POST", "/api/sites/{site}/request-groups/{group}/cancel"): AccessNeed.SEE,
        ("POST", "/api/sites/{site}/request-groups/{group}/approve"): AccessNeed.APPROVE,
        ("POST", "/api/sites/{site}/request-groups/{group}/retry"): AccessNeed.APPROVE,
        # Each picture's camera is looked at besides, and the proposal.
        ("GET", "/api/sites/{site}/requests/{number}/frames"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/proposals/{proposal}/pictures"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/obscore"): AccessNeed.SEE,
        # Of the plan only the times of what is not one's own.
        ("GET", "/api/sites/{site}/night"): AccessNeed.VIEW,
        ("GET", "/api/sites/{site}/night/forecast"): AccessNeed.VIEW,
        ("GET", "/api/sites/{site}/night/week"): AccessNeed.VIEW,
        ("POST", "/api/sites/{site}/night/arm"): AccessNeed.ARM,
        ("POST", "/api/sites/{site}/night/disarm"): AccessNeed.ARM,
        ("POST", "/api/sites/{site}/night/short"): AccessNeed.ARM,
    },
    "alert_notices": {
        # Each proposal is looked at besides, as above: its members see its rules, and who leads it
        # changes them.
        ("GET", "/api/sites/{site}/proposals/{proposal}/alert-rules"): AccessNeed.REQUEST,
        ("POST", "/api/sites/{site}/proposals/{proposal}/alert-rules"): AccessNeed.REQUEST,
        ("PUT", "/api/sites/{site}/proposals/{proposal}/alert-rules/{rule}"): AccessNeed.REQUEST,
        ("DELETE", "/api/sites/{site}/proposals/{proposal}/alert-rules/{rule}"): AccessNeed.REQUEST,
        # Nothing is kept by this.
        ("POST", "/api/sites/{site}/proposals/{proposal}/alert-preview"): AccessNeed.REQUEST,
        # By a token alone, and only for proposals in which its person may ask.
        ("POST", "/api/sites/{site}/alert-notices"): AccessNeed.REQUEST,
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
        ("GET", "/api/sites/{site}/films/{recording}/picture"): AccessNeed.SEE,
        # Each topic is looked at besides, as of those that are live.
        ("GET", "/api/sites/{site}/recorded-topics"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/recorded-topics/messages"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/recorded-topics/bytes"): AccessNeed.SEE,
    },
    "taps": {
        # Each topic is looked at besides; what may not be tapped is as if it were not there.
        ("GET", "/api/sites/{site}/topics"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/graph"): AccessNeed.SEE,
        # Who views no device of the site gets none, as with the clients of other tools.
        ("GET", "/api/sites/{site}/assets"): AccessNeed.SEE,
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
    "maps": {
        # The ground is the same for all; what lies on it each site gives by its own rights.
        ("GET", "/api/maps"): AccessNeed.SESSION,
        ("GET", "/api/maps/files/{name}"): AccessNeed.SESSION,
        ("GET", "/api/maps/sources/{source}/session"): AccessNeed.SESSION,
        ("POST", "/api/maps/sources"): AccessNeed.ADMIN,
        ("DELETE", "/api/maps/sources/{source}"): AccessNeed.ADMIN,
    },
    "notes": {
        # The device that a note is about is looked at besides, as in the logbook (decision 0201);
        # what may not be seen is as if it were not there.
        ("GET", "/api/sites/{site}/notes"): AccessNeed.SEE,
        ("GET", "/api/sites/{site}/notes/export"): AccessNeed.SEE,
        # The right use on what it is about is asked for besides; of a note that is there to be its
        # author, or an admin.
        ("POST", "/api/sites/{site}/notes"): AccessNeed.SEE,
        ("PUT", "/api/sites/{site}/notes/{note}"): AccessNeed.SEE,
        ("DELETE", "/api/sites/{site}/notes/{note}"): AccessNeed.SEE,
    },
    "robot_log": {
        # Of the whole site: a node may say anything of any device.
        ("GET", "/api/sites/{site}/log"): AccessNeed.VIEW,
        ("GET", "/api/sites/{site}/log/nodes"): AccessNeed.VIEW,
    },
    "boards": {
        # Each board is looked at besides (`auth.board_access`); one that is not open to a person
        # is as if it were not there. A board opens no data: each of its tiles asks for its own.
        ("GET", "/api/boards"): AccessNeed.SESSION,
        ("GET", "/api/boards/{board}"): AccessNeed.SESSION,
        ("GET", "/api/boards/{board}/versions"): AccessNeed.SESSION,
        ("GET", "/api/boards/{board}/versions/{number}"): AccessNeed.SESSION,
        # Nothing is kept by these.
        ("POST", "/api/boards/text"): AccessNeed.SESSION,
        ("POST", "/api/boards/reading"): AccessNeed.SESSION,
        # By a person; of a board that is there its owner, or an admin of the hub.
        ("POST", "/api/boards"): AccessNeed.OWN,
        ("PUT", "/api/boards/{board}"): AccessNeed.OWN,
        ("DELETE", "/api/boards/{board}"): AccessNeed.OWN,
        ("POST", "/api/boards/{board}/versions/{number}/restore"): AccessNeed.OWN,
        # The right use at the board's site is asked for besides.
        ("PUT", "/api/boards/{board}/share"): AccessNeed.OWN,
        # What everybody sees, guests and screens too, an admin puts there.
        ("PUT", "/api/boards/{board}/public"): AccessNeed.ADMIN,
    },
    "missions": {
        # Of the whole site: a mission may use several devices, and each of its commands is looked
        # at besides. No script begins one or saves one: a run has all rights of its account.
        ("GET", "/api/sites/{site}/missions"): AccessNeed.VIEW,
        ("POST", "/api/sites/{site}/missions"): AccessNeed.USE,
        # Nothing is kept by this.
        ("POST", "/api/sites/{site}/missions/reading"): AccessNeed.USE,
        ("PUT", "/api/sites/{site}/missions/{mission}"): AccessNeed.USE,
        ("DELETE", "/api/sites/{site}/missions/{mission}"): AccessNeed.USE,
        ("GET", "/api/sites/{site}/missions/{mission}/text"): AccessNeed.VIEW,
        ("POST", "/api/sites/{site}/missions/{mission}/start"): AccessNeed.USE,
        ("GET", "/api/sites/{site}/mission-runs"): AccessNeed.VIEW,
        ("POST", "/api/sites/{site}/mission-runs/act"): AccessNeed.USE,
    },
    "hubs": {
        ("GET", "/api/hubs"): AccessNeed.ADMIN,
    },
    "releases": {
        ("GET", "/api/releases"): AccessNeed.ADMIN,
        ("POST", "/api/rollouts"): AccessNeed.ADMIN,
        ("POST", "/api/rollouts/stop"): AccessNeed.ADMIN,
    },
    "support": {
        # Host names, addresses and logs of the hub's machine; no secrets.
        ("POST", "/api/support-bundle"): AccessNeed.ADMIN,
    },
    "storage": {
        ("GET", "/api/storage"): AccessNeed.ADMIN,
        ("GET", "/api/storage/outlook"): AccessNeed.ADMIN,
    },
    "pages": {
        # For whoever watches the hub from outside, without an account.
        ("GET", "/api/me/units"): AccessNeed.OWN,
        ("PUT", "/api/me/units"): AccessNeed.OWN,
        ("GET", "/api/health"): AccessNeed.OPEN,
        # The same for load balancers.
        ("GET", "/api/ready"): AccessNeed.OPEN,
        ("GET", "/api/openapi.json"): AccessNeed.ADMIN,
        # Lists what is open to the person, and no more.
        ("GET", "/api/devices"): AccessNeed.SESSION,
        ("GET", "/api/commands"): AccessNeed.SESSION,
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
    # The camera's own visibility is looked at besides.
    "/ws/media/unblurred": AccessNeed.UNBLURRED,
    # The topic is looked at besides; what may not be tapped is as if it were not there.
    "/ws/topic": AccessNeed.SEE,
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
