"""Every JSON body of the HTTP API; the browser's types are made from these.

Times ending in ``_us`` are microseconds since the epoch (UTC). Long, because the bodies of sites,
gateways and the audit log are read together; those of people and roles are in `account_schemas`.

Closed lists are the domain's own (`SignalType`, `Right`, `AlarmKind`), and what says the same in
the domain is served as it is (`Capabilities`, `Span`, `BrokenExtension`, `BrokenTile`). The other
bodies are not the domain's types with another name:

* ids are texts here, because JSON's numbers do not hold them (people, gateways, frames, sightings);
* NaN is null (statistics, outliers, frames), and what is left out of a description is filled in
  (digits of a unit, names of arguments, the greatest speed backwards);
* they leave out what the person may not see, or is the gateway's business (sources, secrets);
* `PlaceShape` and `EscalationShape` repeat a part of the description: those are msgspec's, which
  the framework of these routes can neither check nor describe;
* `GapShape`, `ReadingShape` and `OutlierShape` are tuples inside, as millions of them are made.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from talaia.hub.api.driving.drive_schemas import DrivenJointShape  # noqa: TC001 - pydantic reads it
from talaia.hub.api.maps.map_schemas import SiteMapShape  # noqa: TC001 - pydantic reads it
from talaia.hub.api.schemas.observatory_schemas import (  # noqa: TC001 - pydantic reads them
    EnclosureShape,
    PlaceShape,
    PointingShape,
    RuleShape,
    SlewShape,
    StateNeed,
)
from talaia.hub.api.schemas.sighting_schemas import (  # noqa: TC001 - pydantic reads them
    LaneShape,
    PictureMarkShape,
    PictureModelShape,
    SeenShape,
)
from talaia.hub.auth.permissions import Right  # noqa: TC001 - pydantic reads it
from talaia.model.closed_lists import (  # noqa: TC001 - pydantic reads them
    ArgumentType,
    DeviceKind,
    PositionFrame,
    SignalType,
)
from talaia.model.roles import (  # noqa: TC001 - pydantic reads them
    CommandRole,
    SignalRole,
    StateMeaning,
)

__all__ = [
    "ArgumentShape",
    "AuditAsk",
    "AuditChain",
    "AuditList",
    "AuditPage",
    "AuditRow",
    "CommandShape",
    "DetectShape",
    "DeviceShape",
    "DriveShape",
    "EventList",
    "EventShape",
    "HeadsAsk",
    "HeadsKept",
    "Health",
    "LoginAsk",
    "Me",
    "NewWitnessedHub",
    "PermissionShape",
    "ProblemShape",
    "SetupAsk",
    "ShownUnitShape",
    "SignalShape",
    "SiteShape",
    "SiteSummary",
    "StreamShape",
    "WitnessedHubAsk",
    "WitnessedHubList",
    "WitnessedHubShape",
]

# The short name of a site or a device, or all of them.
_PLACE = Field(pattern=r"^(\*|[a-z][a-z0-9_]{0,62})$")


class Schema(BaseModel):
    """A key that is not described is an error, not a silence."""

    # `_no_nul` looks at the texts of one level; nested shapes look at their own.
    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="after")
    def _no_nul(self) -> Self:
        # PostgreSQL stores none, and no text that people write holds one.
        if any(isinstance(value, str) and "\0" in value for value in self.__dict__.values()):
            raise ValueError("a text holds the character NUL")
        return self


class ProblemShape(Schema):
    """What went wrong: a word for programs, a sentence for people."""

    code: str
    message: str


class Health(Schema):
    """The hub answers."""

    ok: bool


class LoginAsk(Schema):
    """Sign in; ``code`` is of the authenticator, or a recovery code, where there is a factor."""

    name: str = Field(min_length=1, max_length=200)
    # Longer than any that is taken: `Passwords` says no to those, in the usual time.
    password: str = Field(max_length=4096)
    code: str = Field(default="", max_length=64)


class SetupAsk(Schema):
    """Make the first admin, with the token of the set-up link."""

    token: str = Field(min_length=1, max_length=200)
    name: str = Field(min_length=1, max_length=200)
    password: str = Field(max_length=4096)


class PermissionShape(Schema):
    """A right (view, use, tap or admin) on a site and a device; ``*`` stands for each of them."""

    right: Right
    site: str = _PLACE
    device: str = _PLACE


class Me(Schema):
    """Who is signed in, until when unless used, and until when at most.

    ``admin`` holds for the whole hub; ``factor``: you sign in with a second factor;
    ``factor_missing``: your role requires one, and nothing is open before it is set up;
    ``codes_locked_us``: when many wrong codes were given; ``password``: you have one here.
    """

    name: str
    role: str
    admin: bool
    factor: bool
    factor_missing: bool
    codes_locked_us: int  # UTC; 0: never, or seen
    password: bool
    idle_ends_us: int  # UTC; moves on with each use
    ends_us: int  # UTC; fixed at the sign-in
    permissions: list[PermissionShape]


class SiteSummary(Schema):
    """A site in the list.

    ``devices`` and ``signals`` count what you may see, ``stale`` those of the signals that are
    older than their limit or have never come.
    """

    site: str
    name: str
    zone: str
    online: bool
    since_us: int  # online or offline since then (UTC)
    last_seen_us: int  # end of the last link (UTC); 0 before the first
    why: str  # it is away, in words; empty while it is connected
    loop_ms: float  # hub to gateway and back
    skew_ms: float  # how far the gateway's wall clock is ahead of the hub's
    rival_us: int  # when another gateway with its identity was there last (UTC); 0: none
    devices: int
    signals: int
    stale: int
    group: str  # under which it stands among many; empty for none
    tags: list[str]
    state: str  # a state in words, with the name of its device; empty where there is none
    battery: float | None  # how full the emptiest battery is (%); None: not known now
    # Where its robot is (°), while ``moving``; else where the site is, where that is described.
    latitude: float | None
    longitude: float | None
    moving: bool
    heading: float | None  # of the robot, clockwise from true north (°)
    driver: str  # who drives something of it; empty for nobody
    stream: str  # a camera of it, ``device/stream``; empty for none
    stops: list[str]  # devices of it that have STOP (software) and that you may stop


class ShownUnitShape(Schema):
    """How values of a unit are shown to you: times ``factor``, plus ``offset``."""

    unit: str
    factor: float
    offset: float
    decimals: int


class SignalShape(Schema):
    """A signal; ``channels`` are the addresses to subscribe to.

    ``unit`` is that of its values everywhere; a page shows them as ``shown`` says, where it does.

    ``max_age`` is in seconds, and 1e9 of one that never goes stale.

    ``role``: what it is, as described or proposed. ``meanings``: what each state means, as
    described or proposed; empty where no state is out of the ordinary. ``public``: everybody who
    is signed in may see it. ``ros``: it is a node's parameter, or the state of its life cycle.
    """

    id: str
    address: str
    name: str
    type: SignalType
    role: SignalRole
    unit: str
    decimals: int
    minimum: float | None
    maximum: float | None
    states: list[str]
    meanings: list[StateMeaning]
    frame: PositionFrame | Literal[""]
    max_age: float
    primary: bool
    public: bool
    ros: Literal["", "parameter", "lifecycle"]
    channels: list[str]
    shown: ShownUnitShape | None


class DetectShape(Schema):
    """What of a camera's pictures is counted: classes, and how sure (0 to 1) at the least."""

    classes: list[str]
    confidence: float
    zones: list[PictureMarkShape] = []
    lines: list[PictureMarkShape] = []


class StreamShape(Schema):
    """A camera. ``max_rate`` is in Hz; ``detect`` is null where nothing is looked for.

    ``blurred``: faces and the like leave its gateway blurred; ``may_unblur``: you may see its
    pictures as they are.
    """

    id: str
    address: str
    name: str
    max_rate: float
    public: bool
    detect: DetectShape | None = None
    lane: LaneShape | None = None
    models: list[PictureModelShape] = []
    blurred: bool = False
    may_unblur: bool = False


class ArgumentShape(Schema):
    """One argument of a command."""

    id: str
    name: str
    type: ArgumentType
    unit: str
    minimum: float | None
    maximum: float | None
    max_length: int
    default: bool | int | float | str | None


class CommandShape(Schema):
    """A one-shot command. ``timeout`` is in seconds; ``cancellable``: it can be ended early.

    ``role``: what it does, as described or proposed. ``needs``: a transition of a life cycle is
    possible in some states of its node only. ``ros``: it sets parameters, or is such a transition.
    """

    id: str
    name: str
    role: CommandRole
    description: str
    confirm: bool
    timeout: float
    cancellable: bool
    arguments: list[ArgumentShape]
    needs: StateNeed | None
    ros: Literal["", "parameter", "lifecycle"]


class DriveShape(Schema):
    """How a device is driven: m/s, rad/s, Hz and seconds. ``stop``: it has STOP (software).

    Pages show speeds and turns to you as ``shown_speed`` and ``shown_turn`` say, where they do.
    """

    max_speed: float  # m/s
    max_reverse: float
    max_sideways: float  # 0: it does not move sideways
    max_turn: float  # rad/s; 0: it does not turn by itself
    max_steering: float  # rad; above 0: it steers by the angle of its wheels
    joints: list[DrivenJointShape]
    ptz: bool  # they are pan (to the right), tilt (up) and zoom (in) of a camera
    rate: float  # Hz
    ttl: float
    lease: float
    picture: str
    position: str
    stop: bool
    shown_speed: ShownUnitShape | None
    shown_turn: ShownUnitShape | None


class DeviceShape(Schema):
    """A device as far as you may see it; ``rights`` are yours: view, use, admin.

    ``link_loss`` says what its gateway does with it when the hub is out of reach, ``pointing``
    where a telescope may not point, ``slew`` how it is pointed to a place in the sky.
    ``unguarded``: a dome or telescope that nothing closes or parks by itself.
    ``twin_of``: it is the simulated twin of this device; empty: it is real.
    """

    id: str
    name: str
    kind: DeviceKind
    signals: list[SignalShape]
    streams: list[StreamShape]
    commands: list[CommandShape]
    drive: DriveShape | None
    public: bool
    link_loss: str
    pointing: PointingShape | None
    slew: SlewShape | None
    rights: list[Right]
    unguarded: bool
    twin_of: str = ""


class SiteShape(Schema):
    """A site as far as you may see it; ``rules`` are its interlocks, ``enclosures`` its roofs."""

    site: str
    name: str
    zone: str
    online: bool
    since_us: int
    last_seen_us: int
    catalogue: str  # names the description as it is now; another one has another
    place: PlaceShape | None
    devices: list[DeviceShape]
    rules: list[RuleShape]
    enclosures: list[EnclosureShape]
    # By the unit of values as they are stored; of units that are shown as they are there is none.
    shown_units: dict[str, ShownUnitShape]
    map: SiteMapShape | None  # what it draws on a map; None: nothing, or none of it is yours to see


class EventShape(Schema):
    """Something that happened. ``sighting``: what a camera saw, while it is kept."""

    id: str
    time_us: int
    kind: str
    device: str
    who: str
    message: str
    good: bool
    sighting: SeenShape | None = None


class EventList(Schema):
    """The newest events first. ``more``: older ones of the window were left out."""

    events: list[EventShape]
    more: bool


class AuditRow(Schema):
    """One row of the audit log."""

    id: str
    time_us: int
    kind: str
    who: str
    address: str
    site: str
    device: str
    message: str
    good: bool
    # Whose word it is: `hub` or `gateway`; empty in rows of before this was written down.
    source: str


# A text to look for; no database holds a NUL.
_TEXT = Field(default=None, max_length=200, pattern=r"^[^\x00]*$")


class AuditAsk(Schema):
    """Which rows of the audit log are meant; what is left out does not matter.

    ``kind`` is its beginning: ``command`` finds all about commands, ``command,stop`` all about
    either. ``from_us`` is included, ``to_us`` is not; ``before`` is the id of a row, for the ones
    after it in the list.
    """

    who: str | None = _TEXT
    site: str | None = _TEXT
    device: str | None = _TEXT
    kind: str | None = _TEXT
    good: bool | None = None
    from_us: int | None = Field(default=None, ge=0, le=2**53)
    to_us: int | None = Field(default=None, ge=0, le=2**53)
    before: int | None = Field(default=None, ge=0, le=2**53)


class AuditPage(AuditAsk):
    """The same, and how many rows at most."""

    limit: int = Field(default=100, ge=1, le=1000)


class AuditList(Schema):
    """Rows, newest first; with ``more``, ask again with the last one's id as ``before``."""

    rows: list[AuditRow]
    more: bool


class AuditChain(Schema):
    """Whether every row follows from the one before.

    ``rows`` counts those that do; ``broken`` is the id of the first that does not, or 0. ``heads``
    counts the signed heads that the chain passes; ``problem`` says why they cannot be read.
    """

    ok: bool
    rows: int
    broken: int
    heads: int = 0
    problem: str = ""


class WitnessedHubShape(Schema):
    """Another hub that leaves signed heads of its audit log here. Times in µs (UTC), 0: never.

    ``key`` is the short name of its key, empty until its first heads came. ``row`` is the newest
    row that it has named, at ``time_us`` by its own clock. ``problem`` says what does not fit
    together: its log was made anew, or cut off.
    """

    id: str
    name: str
    key: str
    keep_days: int
    created_us: int
    heard_us: int
    heads: int
    row: int
    time_us: int
    problem: str


class WitnessedHubList(Schema):
    """All of them, the newest first."""

    hubs: list[WitnessedHubShape]


class WitnessedHubAsk(Schema):
    """Let another hub leave its heads here; each is kept for so many days."""

    name: str = Field(min_length=1, max_length=100)
    keep_days: int = Field(730, ge=7, le=3660)


class NewWitnessedHub(Schema):
    """The token, shown this once; it goes into the file that the other hub's token_file names."""

    id: str
    token: str


class HeadsAsk(Schema):
    """Leave heads here: the hub's token, its public key, and lines as they are in its file."""

    token: str = Field(min_length=1, max_length=200)
    key: str = Field(pattern=r"^[A-Za-z0-9+/]{43}=$")
    lines: list[Annotated[str, Field(max_length=1000)]] = Field(max_length=500)


class HeadsKept(Schema):
    """They are kept, or were before."""

    kept: int
