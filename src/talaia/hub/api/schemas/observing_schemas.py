"""What the routes of proposals and requests take and give. Times in ``_us`` are µs (UTC).

They repeat `talaia.model.observing`: those are msgspec's, which the framework of these routes can
neither check nor describe; and there times are seconds, as planners count. Long,
because the forms of one subject are read together.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, StringConstraints

from talaia.hub.api.schemas.ability_schemas import AbilitiesShape  # noqa: TC001 - as below
from talaia.hub.api.schemas.common import Schema
from talaia.hub.observing.proposal_access import ProposalRole  # noqa: TC001 - pydantic reads it
from talaia.model.observing.plan import VetoCause  # noqa: TC001 - pydantic reads it
from talaia.model.observing.requests import GroupOperator, Guiding, ImageType, Urgency
from talaia.model.observing.states import (  # noqa: TC001 - pydantic reads them
    ObservationState,
    RequestState,
)
from talaia.model.observing.targets import SolarSystemBody  # noqa: TC001 - pydantic reads it
from talaia.wire.gateway_messages.relayed_fields import NightPhase  # noqa: TC001 - as above

__all__ = [
    "ConfigurationShape",
    "ConstraintsShape",
    "FixedTargetShape",
    "GroupAsk",
    "GroupShape",
    "IcrsTargetShape",
    "MemberAsk",
    "MemberShape",
    "MovingTargetShape",
    "NightAnswer",
    "NightArmAsk",
    "NightStateShape",
    "ObservationShape",
    "PhaseShape",
    "PlanBlockShape",
    "PlanPauseShape",
    "PlanShape",
    "ProposalAsk",
    "ProposalChange",
    "ProposalList",
    "ProposalShape",
    "ReasonAsk",
    "RequestAsk",
    "RequestDetail",
    "RequestList",
    "RequestLogLine",
    "RequestRow",
    "RequestShape",
    "SiteNightShape",
    "WhyNotShape",
    "WindowShape",
]

_Id = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$")]
_Title = Annotated[str, StringConstraints(max_length=200, pattern=r"^[^\x00]*$")]
_Words = Annotated[str, StringConstraints(max_length=1000, pattern=r"^[^\x00]*$")]
_TargetName = Annotated[str, StringConstraints(max_length=100, pattern=r"^[^\x00]*$")]
_Filter = Annotated[str, StringConstraints(max_length=40, pattern=r"^[^\x00]*$")]
_Degrees = Annotated[float, Field(ge=0, lt=360)]
_Motion = Annotated[float, Field(ge=-20_000, le=20_000)]
# Up to the year 2514.
_Moment = Annotated[int, Field(ge=0, le=2**34 * 1_000_000)]
_Hours = Annotated[float, Field(ge=0, le=100_000)]
_Phase = Annotated[float, Field(ge=0, le=1)]
_Priority = Annotated[float, Field(gt=0, le=1000)]
_MOST_REQUESTS = 1000


class IcrsTargetShape(Schema):
    """A place among the stars (°, ICRS); proper motion as Gaia gives it (mas/year).

    ``position_angle``: where a picture's top points, from north through east; none: as it stands.
    """

    type: Literal["ICRS"]
    name: _TargetName = ""
    ra: _Degrees
    dec: float = Field(ge=-90, le=90)
    proper_motion_ra: _Motion = 0.0
    proper_motion_dec: _Motion = 0.0
    epoch: float = Field(default=2000.0, ge=1800, le=2200)
    position_angle: _Degrees | None = None


class MovingTargetShape(Schema):
    """A body of the solar system."""

    type: Literal["SOLAR_SYSTEM"]
    name: _TargetName = ""
    body: SolarSystemBody


class FixedTargetShape(Schema):
    """A place above the horizon, where nothing is tracked (°; azimuth from north through east)."""

    type: Literal["FIXED"]
    name: _TargetName = ""
    altitude: float = Field(ge=0, le=90)
    azimuth: _Degrees


TargetShape = Annotated[
    IcrsTargetShape | MovingTargetShape | FixedTargetShape, Field(discriminator="type")
]


class ConfigurationShape(Schema):
    """Frames of one kind: ``exposure`` in s, ``dither`` in ″; no ``gain``: as it is."""

    type: ImageType = ImageType.LIGHT
    filter: _Filter = ""
    exposure: float = Field(ge=0, le=86_400)
    count: int = Field(default=1, ge=1, le=10_000)
    binning: int = Field(default=1, ge=1, le=16)
    gain: Annotated[float, Field(ge=-1e6, le=1e6)] | None = None
    dither: float = Field(default=0.0, ge=0, le=600)
    guiding: Guiding = Guiding.OFF


class PhaseShape(Schema):
    """A part of a period (``period_s`` in s), from phase ``start`` to ``end``."""

    epoch_us: _Moment
    period_s: float = Field(gt=0, le=1e10)
    start: _Phase
    end: _Phase


class ConstraintsShape(Schema):
    """What must hold all the time that a request is observed; none: it does not matter.

    Altitudes and distances in °, ``max_hour_angle`` in h, ``max_seeing`` in ″, ``max_clouds`` in %.
    """

    min_altitude: float = Field(default=15.0, ge=0, le=90)
    max_airmass: float = Field(default=10.0, ge=1, le=40)
    min_moon_distance: float = Field(default=0.0, ge=0, le=180)
    max_moon_illumination: float = Field(default=1.0, ge=0, le=1)
    max_sun_altitude: float = Field(default=-12.0, ge=-90, le=0)
    max_hour_angle: Annotated[float, Field(gt=0, le=12)] | None = None
    max_seeing: Annotated[float, Field(gt=0, le=60)] | None = None
    max_clouds: Annotated[float, Field(ge=0, le=100)] | None = None
    phase: PhaseShape | None = None


class WindowShape(Schema):
    """From when to when a request may be observed."""

    start_us: _Moment
    end_us: _Moment


class RequestAsk(Schema):
    """One visit: what is taken of what, when and under which conditions."""

    # None: frames that need no sky.
    target: TargetShape | None = None
    configurations: list[ConfigurationShape] = Field(min_length=1, max_length=100)
    constraints: ConstraintsShape = ConstraintsShape()
    windows: list[WindowShape] = Field(min_length=1, max_length=1000)


class GroupAsk(Schema):
    """Requests that are handed in together; a ``draft`` is only kept."""

    proposal: _Id
    name: _Title = ""
    operator: GroupOperator = GroupOperator.SINGLE
    urgency: Urgency = Urgency.NORMAL
    priority: _Priority = 10.0
    requests: list[RequestAsk] = Field(min_length=1, max_length=_MOST_REQUESTS)
    draft: bool = False


class RequestShape(Schema):
    """A request of a group, as it stands; ``charge_s`` is an estimate (s)."""

    id: str
    target: TargetShape | None
    configurations: list[ConfigurationShape]
    constraints: ConstraintsShape
    windows: list[WindowShape]
    state: RequestState
    frames_done: list[int]
    failures: int
    charge_s: float


class GroupShape(Schema):
    """A request group, as it stands.

    ``waits``: it is handed in and waits to be approved; ``may``: what you may do with it now.
    """

    id: str
    proposal: str
    name: str
    requester: str
    mine: bool
    operator: GroupOperator
    urgency: Urgency
    priority: float
    created_us: int
    submitted_us: int
    approved_us: int
    approved_by: str
    waits: bool
    charge_s: float
    requests: list[RequestShape]
    may: list[Literal["edit", "submit", "withdraw", "approve", "cancel", "retry"]]


class WhyNotShape(Schema):
    """Why a request is not observed now.

    ``until_us``: when that ends; none: not in this night. ``planned_us``: when the plan has it.
    """

    cause: VetoCause
    message: str
    until_us: int | None
    planned_us: int | None


class RequestRow(Schema):
    """A request in a list; ``why_not`` is of the newest plan, and none while it is observed."""

    id: str
    group: str
    group_name: str
    proposal: str
    requester: str
    mine: bool
    target: str
    state: RequestState
    urgency: Urgency
    priority: float
    charge_s: float
    start_us: int
    end_us: int
    changed_us: int
    waits: bool
    why_not: WhyNotShape | None


class RequestList(Schema):
    """Requests, the newest first; ``more``: ask again with ``before`` as the last one's id."""

    requests: list[RequestRow]
    more: bool


class RequestLogLine(Schema):
    """A change of a request's state; ``who`` is empty where the hub or the gateway did it."""

    time_us: int
    who: str
    before: RequestState | None
    after: RequestState
    why: str


class ObservationShape(Schema):
    """One try at a request; ``frames_done`` of each configuration, in all tries."""

    id: str
    state: ObservationState
    cause: str
    why: str
    began_us: int
    changed_us: int
    frames_done: list[int]
    charge_s: float
    files: list[str]


class RequestDetail(Schema):
    """A request with its group, its log and its observations."""

    request: RequestShape
    group: GroupShape
    why_not: WhyNotShape | None
    log: list[RequestLogLine]
    observations: list[ObservationShape]


class ReasonAsk(Schema):
    """Why something is done, as it will stand in the log."""

    why: _Words = ""


class MemberShape(Schema):
    """Who is in a proposal, and as what."""

    name: str
    role: ProposalRole


class MemberAsk(Schema):
    """Let an account be in a proposal; without a role: no more."""

    name: Annotated[str, StringConstraints(min_length=1, max_length=200, pattern=r"^[^\x00]*$")]
    role: ProposalRole | None = None


class ProposalChange(Schema):
    """What of a proposal can be changed.

    ``share`` of the shutter time is 0 to 1; ``hours_allocated`` is block time in all,
    ``person_hours`` of each member (0: as much as there is); ``urgencies`` beside NORMAL may be
    asked for; ``is_open``: whoever may view the site sees its requests.
    """

    title: _Title = ""
    share: float = Field(default=0.0, ge=0, le=1)
    hours_allocated: _Hours
    person_hours: _Hours = 0.0
    max_priority: _Priority = 20.0
    urgencies: list[Urgency] = Field(default=[], max_length=3)
    active: bool = True
    is_open: bool = False
    needs_approval: bool = False


class ProposalAsk(ProposalChange):
    """A new proposal."""

    id: _Id


class ProposalShape(Schema):
    """A proposal that is open to you.

    ``role``: yours in it; ``may_ask``: in its name; ``may_lead``: change and end what others asked.
    ``used_s`` was observed, ``promised_s`` is asked for and waits.
    """

    id: str
    title: str
    share: float
    hours_allocated: float
    person_hours: float
    max_priority: float
    urgencies: list[Urgency]
    active: bool
    is_open: bool
    needs_approval: bool
    used_s: float
    promised_s: float
    role: ProposalRole | None
    may_ask: bool
    may_lead: bool
    members: list[MemberShape]


class ProposalList(Schema):
    """A site's proposals that are open to you, and what you may do at its nights.

    ``observes``: it has a telescope; without one nothing can be asked for. ``abilities`` is what
    can be asked for, for those who may ask.
    """

    observes: bool
    may_request: bool
    may_approve: bool
    may_arm: bool
    may_manage: bool
    abilities: AbilitiesShape | None
    proposals: list[ProposalShape]


class NightStateShape(Schema):
    """How the night stands, as the gateway said at ``heard_us``; see `NightUpdate`.

    ``site_time_us``: what time it is at a simulated site that lives faster than people do, and
    ``speed``: so many times as fast; 0 both: its time is everybody's.
    """

    phase: NightPhase
    armed_by: str
    armed_until_us: int
    why: str
    since_us: int
    request: str
    step: str
    frames_done: int
    frames: int
    heard_us: int
    site_time_us: int
    speed: float


class PlanPauseShape(Schema):
    """What a plan counts with between exposures: ``kind`` is ``flip`` or ``focus``."""

    kind: str
    start_us: int
    end_us: int
    reason: str


class PlanBlockShape(Schema):
    """One visit of a plan; what of it is not open to you is empty."""

    request: str
    proposal: str
    target: str
    start_us: int
    end_us: int
    overhead_s: float
    reason: str
    pauses: list[PlanPauseShape]


class PlanShape(Schema):
    """A night from now on; ``bound``: no plan is worth more (none: not worked out)."""

    made_us: int
    night_start_us: int
    night_end_us: int
    method: str
    value: float
    bound: float | None
    blocks: list[PlanBlockShape]


class SiteNightShape(Schema):
    """A site's night: how it stands and what its gateway plans, as it said last.

    ``simulated``: its hub was told that the site is a simulator. ``time_lapse``: the simulated site
    at which a whole night can be lived through at high speed; empty: there is none.
    """

    online: bool
    simulated: bool
    time_lapse: str
    state: NightStateShape | None
    plan: PlanShape | None


class NightArmAsk(Schema):
    """Let the night run by itself until then (0: until somebody disarms it)."""

    until_us: _Moment = 0


class NightAnswer(Schema):
    """What the gateway answered; ``refused`` is empty where it did as asked."""

    state: NightStateShape
    refused: str
