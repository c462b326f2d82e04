"""Night files ``talaia-night/1``: one seeded night of one telescope, as JSON."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from talaia.model.observing.plan import Instrument
from talaia.planner.errors import NotANight
from talaia.planner.night_problem import (
    NORMAL,
    RAPID,
    TIME_CRITICAL,
    FrameRun,
    NightProblem,
    ProposalLimit,
    Visit,
)
from talaia.planner.sky import TelescopePlace, compute_sky

__all__ = ["NightFile", "NightRequest", "make_problem", "make_visits", "read_night"]

_FORMAT = "talaia-night/1"
_URGENCIES = {"normal": NORMAL, "time_critical": TIME_CRITICAL, "rapid": RAPID}

_Second = Annotated[int, Meta(ge=0, le=2 * 86_400)]
_Positive = Annotated[float, Meta(ge=0, le=86_400)]
_Degrees = Annotated[float, Meta(ge=0, le=180)]


class _Site(msgspec.Struct, frozen=True, kw_only=True):
    name: str = ""
    lat: Annotated[float, Meta(ge=-90, le=90)]
    lon: Annotated[float, Meta(ge=-360, le=360)]
    elevation: float = 0.0


class _Instrument(msgspec.Struct, frozen=True, kw_only=True):
    slew_deg_s: Annotated[float, Meta(gt=0)]
    settle_s: _Positive
    acquire_s: _Positive
    filter_s: _Positive
    readout_s: _Positive
    unpark_s: _Positive
    horizon_deg: Annotated[float, Meta(ge=0, le=90)]


class _Proposal(msgspec.Struct, frozen=True, kw_only=True):
    id: str
    share: Annotated[float, Meta(ge=0, le=1)]
    hours_left: Annotated[float, Meta(ge=0)]


class _Rules(msgspec.Struct, frozen=True, kw_only=True):
    resume: bool = False


class _Truth(msgspec.Struct, frozen=True, kw_only=True):
    closed: list[tuple[int, int, str]] = []


class NightRequest(msgspec.Struct, frozen=True, kw_only=True):
    """A visit, as the format has it (seconds of the night, degrees)."""

    id: str
    kind: Literal["normal", "time_critical", "rapid"] = "normal"
    proposal: str
    ra: Annotated[float, Meta(ge=0, le=360)]
    dec: Annotated[float, Meta(ge=-90, le=90)]
    priority: Annotated[float, Meta(gt=0)]
    n: Annotated[int, Meta(ge=1, le=100_000)]
    exp: Annotated[float, Meta(gt=0, le=86_400)]
    filter: str
    windows: list[tuple[_Second, _Second]]
    min_alt: Annotated[float, Meta(ge=0, le=90)] = 0.0
    max_airmass: Annotated[float, Meta(ge=1)] = 40.0
    moon_dist: _Degrees = 0.0
    moon_illum: Annotated[float, Meta(ge=0, le=1)] = 1.0
    sun_alt: Annotated[float, Meta(ge=-90, le=90)] = 0.0
    arrives: _Second = 0


class NightFile(msgspec.Struct, frozen=True, kw_only=True):
    """A night: what a planner is given, and (in ``truth``) what only its judge knows."""

    format: str = _FORMAT
    name: str = ""
    site: _Site
    start: str
    end_s: Annotated[int, Meta(ge=60, le=86_400)]
    instrument: _Instrument
    rules: _Rules = _Rules()
    proposals: list[_Proposal]
    requests: list[NightRequest]
    truth: _Truth = _Truth()


def read_night(text: bytes | str) -> NightFile:
    """Read a night file.

    Raises:
        NotANight: it is not JSON, or not what the format says; names the place.

    """
    try:
        night = msgspec.json.decode(text, type=NightFile)
    except msgspec.DecodeError as error:
        raise NotANight("night", str(error), f"expected JSON of the format {_FORMAT}") from error
    if night.format != _FORMAT:
        raise NotANight("format", f"is {night.format!r}", f"expected {_FORMAT!r}")
    return night


def make_problem(night: NightFile) -> NightProblem:
    """Turn a night file into a problem; what arrives later is left out.

    Raises:
        NotANight: the start is no time, or two requests have one id.

    """
    try:
        start = datetime.fromisoformat(night.start)
    except ValueError as error:
        raise NotANight(
            "start", f"{night.start!r} is no time", "as 2027-01-18T17:25:00Z"
        ) from error
    if start.tzinfo is None:
        start = start.replace(tzinfo=UTC)
    unix = start.timestamp()
    place = TelescopePlace(night.site.lat, night.site.lon, night.site.elevation)
    made = night.instrument
    problem = NightProblem(
        start=unix,
        length_s=night.end_s,
        sky=compute_sky(place, unix, night.end_s),
        instrument=Instrument(
            slew_rate=made.slew_deg_s,
            settle=made.settle_s,
            acquire=made.acquire_s,
            filter_change=made.filter_s,
            readout=made.readout_s,
            unpark=made.unpark_s,
            meridian_flip=0.0,
            focus_run=0.0,
            horizon=made.horizon_deg,
        ),
        resume=night.rules.resume,
        proposals=[
            ProposalLimit(proposal.id, proposal.share, proposal.hours_left * 3600.0)
            for proposal in night.proposals
        ],
    )
    present = [request for request in night.requests if not request.arrives]
    names = [request.id for request in present]
    if len(set(names)) != len(names):
        raise NotANight("requests", "two have the same id", "an id is used once")
    problem.add_visits(make_visits(problem, present))
    return problem


def make_visits(problem: NightProblem, requests: list[NightRequest]) -> tuple[Visit, ...]:
    """Turn requests of a night file into visits.

    Raises:
        NotANight: a request is of a proposal that is not there.

    """
    index = {proposal.id: row for row, proposal in enumerate(problem.proposals)}
    visits = []
    for request in requests:
        if request.proposal not in index:
            raise NotANight(
                f"request {request.id}", f"unknown proposal {request.proposal!r}", "list it"
            )
        row = problem.filter_index(request.filter)
        visits.append(
            Visit(
                id=request.id,
                urgency=_URGENCIES[request.kind],
                proposal=index[request.proposal],
                ra=request.ra,
                dec=request.dec,
                priority=request.priority,
                shutter_s=request.n * request.exp,
                runs=(FrameRun(request.n, request.exp + problem.instrument.readout),),
                filters=(row, row),
                windows=tuple(request.windows),
                arrives=request.arrives,
                min_altitude=request.min_alt,
                max_airmass=request.max_airmass,
                min_moon_distance=request.moon_dist,
                max_moon_illumination=request.moon_illum,
                max_sun_altitude=request.sun_alt,
            )
        )
    return tuple(visits)
