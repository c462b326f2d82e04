"""Night files ``talaia-night/1``: one seeded night of one telescope, as JSON."""

from __future__ import annotations

import re
from datetime import UTC, datetime
from typing import Annotated, Any, Literal, NamedTuple

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

__all__ = [
    "NightFile",
    "NightRequest",
    "ReadNight",
    "make_problem",
    "make_visits",
    "read_night",
    "what_is_wrong",
]

_FORMAT = "talaia-night/1"
_URGENCIES = {"normal": NORMAL, "time_critical": TIME_CRITICAL, "rapid": RAPID}

_Second = Annotated[int, Meta(ge=0, le=2 * 86_400)]
_Positive = Annotated[float, Meta(ge=0, le=86_400)]
_Degrees = Annotated[float, Meta(ge=0, le=180)]
_Name = Annotated[str, Meta(min_length=1)]
# Where in a text its first mistake is, as msgspec says it.
_BYTE = re.compile(r"\(byte (\d+)\)")
_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
# What generators of nights write besides, and no planner needs.
_PASSED_OVER = frozenset({"group"})


class _Site(msgspec.Struct, frozen=True, kw_only=True):
    name: str = ""
    lat: Annotated[float, Meta(ge=-90, le=90)]
    lon: Annotated[float, Meta(ge=-360, le=360)]
    elevation: Annotated[float, Meta(ge=-500, le=10_000)] = 0.0


class _Instrument(msgspec.Struct, frozen=True, kw_only=True):
    slew_deg_s: Annotated[float, Meta(ge=0.001, le=1000)]
    settle_s: _Positive
    acquire_s: _Positive
    filter_s: _Positive
    readout_s: _Positive
    unpark_s: _Positive
    horizon_deg: Annotated[float, Meta(ge=0, le=90)]


class _Proposal(msgspec.Struct, frozen=True, kw_only=True):
    id: _Name
    share: Annotated[float, Meta(ge=0, le=1)]
    hours_left: Annotated[float, Meta(ge=0, le=1_000_000)]


class _Rules(msgspec.Struct, frozen=True, kw_only=True):
    resume: bool = False


class _Truth(msgspec.Struct, frozen=True, kw_only=True):
    closed: list[tuple[int, int, str]] = []


class NightRequest(msgspec.Struct, frozen=True, kw_only=True):
    """A visit, as the format has it (seconds of the night, degrees)."""

    id: _Name
    kind: Literal["normal", "time_critical", "rapid"] = "normal"
    proposal: str
    ra: Annotated[float, Meta(ge=0, le=360)]
    dec: Annotated[float, Meta(ge=-90, le=90)]
    priority: Annotated[float, Meta(gt=0, le=1e9)]
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


class ReadNight(NamedTuple):
    """A file of a night.

    Attributes:
        night: what its format has of it.
        unknown: keys that the format does not have, and nobody reads: how often each stands there,
            by its place: ``requests[].min_altitude``.

    """

    night: NightFile
    unknown: dict[str, int]


def read_night(text: bytes) -> ReadNight:
    """Read a night file; a byte-order mark before it is passed over.

    Raises:
        NotANight: it is not JSON, or not what the format says; names the place.

    """
    text = text.removeprefix(_BYTE_ORDER_MARK)
    try:
        plain = msgspec.json.decode(text)
        night = msgspec.convert(plain, NightFile)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        problem = what_is_wrong(text, error)
        raise NotANight("night", problem, f"expected JSON of the format {_FORMAT}") from error
    if night.format != _FORMAT:
        raise NotANight("format", f"is {night.format!r}", f"expected {_FORMAT!r}")
    return ReadNight(night, _unknown_keys(plain))


def what_is_wrong(text: bytes, error: Exception) -> str:
    """Say why JSON was not read, by line and column, as editors count them."""
    if not text.strip():
        return "it is empty"

    def in_lines(found: re.Match[str]) -> str:
        before = text[: int(found[1])]
        return f"(line {before.count(10) + 1}, column {len(before) - before.rfind(10)})"

    return _BYTE.sub(in_lines, str(error))


def _unknown_keys(night: dict[str, Any]) -> dict[str, int]:
    parts: list[tuple[str, type[msgspec.Struct], list[dict[str, object]]]] = [
        ("", NightFile, [night]),
        ("site.", _Site, [night["site"]]),
        ("instrument.", _Instrument, [night["instrument"]]),
        ("rules.", _Rules, [night.get("rules", {})]),
        ("proposals[].", _Proposal, night["proposals"]),
        ("requests[].", NightRequest, night["requests"]),
    ]
    found: dict[str, int] = {}
    for place, shape, rows in parts:
        known = _PASSED_OVER.union(shape.__struct_fields__)
        for row in rows:
            for key in row.keys() - known:
                found[place + key] = found.get(place + key, 0) + 1
    return found


def make_problem(night: NightFile) -> NightProblem:
    """Turn a night file into a problem; what arrives later is left out.

    Raises:
        NotANight: the start is no time, two requests or two proposals have one id, or a request
            is none (see `make_visits`).

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
    _refuse_doubles("proposals", [proposal.id for proposal in night.proposals])
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
    _refuse_doubles("requests", [request.id for request in present])
    problem.add_visits(make_visits(problem, present))
    return problem


def _refuse_doubles(where: str, names: list[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise NotANight(where, f"two have the same id {name!r}", "an id is used once")
        seen.add(name)


def make_visits(problem: NightProblem, requests: list[NightRequest]) -> tuple[Visit, ...]:
    """Turn requests of a night file into visits.

    Raises:
        NotANight: a request is of a proposal that is not there, or ends before it begins.

    """
    index = {proposal.id: row for row, proposal in enumerate(problem.proposals)}
    visits = []
    for request in requests:
        if request.proposal not in index:
            raise NotANight(
                f"request {request.id}", f"unknown proposal {request.proposal!r}", "list it"
            )
        for start, end in request.windows:
            if end < start:
                raise NotANight(
                    f"request {request.id}",
                    f"its window ends at {end} s, before it begins at {start} s",
                    "write from, then to",
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
