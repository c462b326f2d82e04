"""From what people ask (`talaia.model.observing`) to a problem for the planner."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.model.observing.plan import PauseRules
from talaia.model.observing.requests import (
    Configuration,
    GroupOperator,
    ImageType,
    Proposal,
    Request,
    RequestGroup,
    Urgency,
)
from talaia.model.observing.states import RequestState
from talaia.model.observing.targets import FixedTarget, IcrsTarget, SolarSystemTarget, Target
from talaia.planner.night_problem import (
    NORMAL,
    RAPID,
    TIME_CRITICAL,
    FrameRun,
    NightProblem,
    ProposalLimit,
    Visit,
)
from talaia.planner.sky import Floats, NightSky, TelescopePlace, compute_sky, find_night

if TYPE_CHECKING:
    from collections.abc import Sequence, Set

    from talaia.model.observing.plan import Instrument

__all__ = ["NO_PAUSES", "limits_of", "make_night", "visits_of"]

_URGENCIES = {
    Urgency.NORMAL: NORMAL,
    Urgency.TIME_CRITICAL: TIME_CRITICAL,
    Urgency.RAPID_RESPONSE: RAPID,
}
NO_PAUSES = PauseRules()
"""Of a mount that never turns over, at a site that nobody focuses."""
# Frames that need no sky: they are taken while the roof is closed.
_INDOORS = frozenset({ImageType.DARK, ImageType.BIAS})
# Of a Julian year, by which proper motions are given (s).
_YEAR_S = 365.25 * 86_400.0
# 2000-01-01T12:00:00 (s since the epoch).
_J2000_UNIX = 946_728_000.0
# Proper motions come in milliarcseconds a year.
_MAS_IN_DEGREES = 1.0 / 3_600_000.0


def make_night(
    place: TelescopePlace,
    time: float,
    *,
    instrument: Instrument,
    pauses: PauseRules = NO_PAUSES,
    proposals: Sequence[Proposal] = (),
    groups: Sequence[RequestGroup] = (),
) -> NightProblem:
    """Make the problem of the night at ``time`` (s since the epoch, UTC), or of the next one.

    A night of no length comes back where the Sun does not set so far.
    """
    start, length_s = find_night(place, time)
    problem = NightProblem(
        start=start,
        length_s=length_s,
        sky=compute_sky(place, start, length_s),
        instrument=instrument,
        pauses=pauses,
        proposals=limits_of(proposals),
    )
    problem.add_visits(visits_of(problem, groups))
    return problem


def limits_of(proposals: Sequence[Proposal]) -> list[ProposalLimit]:
    """Give what proposals are due, and have left."""
    return [_proposal_limit(proposal) for proposal in proposals]


def _proposal_limit(proposal: Proposal) -> ProposalLimit:
    # A proposal that was closed keeps its share, and has nothing left to spend.
    left = max(0.0, proposal.hours_allocated - proposal.hours_used) if proposal.active else 0.0
    return ProposalLimit(proposal.id, proposal.share, left * 3600.0)


def visits_of(problem: NightProblem, groups: Sequence[RequestGroup]) -> tuple[Visit, ...]:
    """Turn the pending requests of groups into visits.

    A group whose proposal is not known pays from an allocation of nothing: it is never planned,
    and `why_not` says so.
    """
    visits: list[Visit] = []
    for group in groups:
        row = _proposal_row(problem, group.proposal)
        previous = ""
        for request in group.requests:
            if request.state is RequestState.PENDING:
                visits.append(_visit(problem, group, request, proposal=row, after=previous))
            if group.operator is GroupOperator.SEQUENCE:
                # One that is done holds nobody up; one that has failed holds up all after it.
                done = request.state is RequestState.COMPLETED
                previous = "" if done else request.id
    return tuple(visits)


def _proposal_row(problem: NightProblem, name: str) -> int:
    for row, proposal in enumerate(problem.proposals):
        if proposal.id == name:
            return row
    # Nobody allows it: a row without time, so that its visits are explained and not lost.
    problem.proposals.append(ProposalLimit(name, 0.0, 0.0))
    return len(problem.proposals) - 1


def _visit(
    problem: NightProblem, group: RequestGroup, request: Request, *, proposal: int, after: str
) -> Visit:
    limits = request.constraints
    ra, dec, track = _place_target(problem.sky, request.target)
    kinds = {configuration.type for configuration in request.configurations}
    waits_for = _without_plan(kinds)
    return Visit(
        id=request.id,
        urgency=_URGENCIES[group.urgency],
        proposal=proposal,
        ra=ra,
        dec=dec,
        track=track,
        # What stands still above the ground has no meridian to turn over at.
        tracked=not isinstance(request.target, FixedTarget),
        needs_sky=not waits_for,
        waits_for=waits_for,
        priority=group.priority,
        shutter_s=sum(part.exposure * part.count for part in request.configurations),
        runs=_frame_runs(problem, request),
        # Of the first and the last frame: what comes between two visits depends on both.
        filters=(
            problem.filter_index(request.configurations[0].filter),
            problem.filter_index(request.configurations[-1].filter),
        ),
        angle=_angle(request.target),
        windows=_windows(problem, request),
        min_altitude=limits.min_altitude,
        max_airmass=limits.max_airmass,
        min_moon_distance=limits.min_moon_distance,
        max_moon_illumination=limits.max_moon_illumination,
        max_sun_altitude=limits.max_sun_altitude,
        # Beyond 12 h there is no hour angle, so this is no limit.
        max_hour_angle=12.0 if limits.max_hour_angle is None else limits.max_hour_angle,
        max_seeing=math.inf if limits.max_seeing is None else limits.max_seeing,
        max_clouds=math.inf if limits.max_clouds is None else limits.max_clouds,
        phase=limits.phase,
        after=after,
    )


def _without_plan(kinds: Set[ImageType]) -> str:
    """Say when frames are taken that are in no plan; empty: they are planned."""
    if kinds == {ImageType.LIGHT}:
        return ""
    if kinds == {ImageType.SKY_FLAT}:
        return "in a twilight"
    return "under a closed roof" if kinds <= _INDOORS else "never, for it mixes frames of all kinds"


def _frame_runs(problem: NightProblem, request: Request) -> tuple[FrameRun, ...]:
    """Give the frames that are not done yet, with what comes between configurations."""
    # Configurations that were never begun are not counted there.
    done = [*request.frames_done, *([0] * len(request.configurations))]
    runs: list[FrameRun] = []
    last: Configuration | None = None
    for part, kept in zip(request.configurations, done, strict=False):
        left = max(0, part.count - kept)
        changes = last is not None and part.filter not in ("", last.filter)
        # Through another filter it is focused on anew.
        change = problem.instrument.filter_change + problem.pauses.focus
        before = change if changes and left else 0.0
        runs.append(FrameRun(left, part.exposure + problem.instrument.readout, before))
        if left:
            last = part
    return tuple(runs)


def _windows(problem: NightProblem, request: Request) -> tuple[tuple[int, int], ...]:
    """Cut windows to the night."""
    cut = []
    for window in request.windows:
        # Inwards: a frame must not begin a part of a second too early, nor end too late.
        begin = max(0, math.ceil(window.start - problem.start))
        end = min(problem.length_s, math.floor(window.end - problem.start))
        if begin < end:
            cut.append((begin, end))
    return tuple(cut)


def _angle(target: Target | None) -> float:
    """Give the position angle that a camera is turned to (°); NaN: none."""
    angle = target.position_angle if isinstance(target, IcrsTarget) else None
    return math.nan if angle is None else angle


def _place_target(sky: NightSky, target: Target | None) -> tuple[float, float, Floats | None]:
    """Give right ascension, declination (°) and, of what moves, its directions (3 × n)."""
    match target:
        case None:
            return 0.0, 0.0, None
        case IcrsTarget():
            years = (float(sky.unix[0]) - _J2000_UNIX) / _YEAR_S + 2000.0 - target.epoch
            dec = target.dec + years * target.proper_motion_dec * _MAS_IN_DEGREES
            # Degrees of right ascension are shorter near a pole; at the pole itself never zero.
            shrink = max(math.cos(math.radians(target.dec)), 1e-6)
            ra = target.ra + years * target.proper_motion_ra * _MAS_IN_DEGREES / shrink
            return ra % 360.0, min(90.0, max(-90.0, dec)), None
        case SolarSystemTarget():
            return _with_middle(sky.body_track(target.body))
        case FixedTarget():
            return _with_middle(sky.fixed_track(target.altitude, target.azimuth))


def _with_middle(track: Floats) -> tuple[float, float, Floats]:
    # Where it is in the middle of the night stands for the way there and back.
    x, y, z = (float(part) for part in track[:, track.shape[1] // 2])
    return math.degrees(math.atan2(y, x)) % 360.0, math.degrees(math.asin(z)), track
