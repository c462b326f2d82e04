"""Why a request is not observed now: the first veto that holds and until when, or who is ahead."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.model.observing.plan import VetoCause, WhyNot
from talaia.planner.dispatch import rank_now
from talaia.planner.feasibility import NEVER, constraint_masks
from talaia.planner.sky import MARK_S

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.planner.night_problem import Visit
    from talaia.planner.progress import NightProgress

__all__ = ["clock_words", "explain_visits"]

# What may end at any moment, or is no matter of a night.
_AT_ANY_MOMENT = frozenset(
    {
        VetoCause.OUTRANKED,
        VetoCause.STATE,
        VetoCause.ROOF,
        VetoCause.SEQUENCE,
        VetoCause.SEEING,
        VetoCause.CLOUDS,
    }
)
_MARK_CAUSES = {cause.value: cause for cause in VetoCause}


class _Veto(NamedTuple):
    cause: VetoCause
    # Second of the night; none: not in this night.
    until: int | None
    words: str


def explain_visits(
    progress: NightProgress,
    second: int,
    rows: Sequence[int],
    *,
    planned: Mapping[int, int],
) -> tuple[WhyNot, ...]:
    """Explain each of the rows; ``planned`` has the start of those in the plan (s of the night)."""
    problem = progress.problem
    visits = [problem.table.visits[row] for row in rows]
    # The sky is not looked at for nobody: it is the dear part of an answer.
    if not rows:
        return ()
    masks = constraint_masks(problem, visits)
    mark = min(max(0, second // MARK_S), len(problem.sky.unix) - 1)
    index = np.array(rows, np.int64)
    start, rate, overhead = rank_now(progress, second, index)
    # Against what each row is weighed: all that could be begun now.
    free = progress.released(progress.candidates(second))
    all_start, all_rate, all_overhead = rank_now(progress, second, free)
    at_once = all_start - second - all_overhead < 2 * MARK_S
    # The one that would be begun now, which is the reason of all that are only outranked.
    leader, best = -1, 0.0
    if at_once.any():
        top = int(np.argmax(np.where(at_once, all_rate, -1.0)))
        leader, best = int(free[top]), float(all_rate[top])
    answers = []
    for place, (row, visit) in enumerate(zip(rows, visits, strict=True)):
        veto = _standing_veto(progress, second, row, visit)
        if veto is None:
            marks = {name: mask[place] for name, mask in masks}
            veto = _sky_veto(progress, mark, visit, marks)
        waits = int(start[place]) - second - int(overhead[place])
        # Allowed at this moment but with a start later on: only its length can be the reason. Two
        # marks of slack, since a start lies on the grid of the sky.
        if veto is None and waits >= 2 * MARK_S:
            veto = _fit_veto(int(start[place]), int(progress.problem.table.block_s[row]))
        when = planned.get(row)
        answers.append(
            _answer(
                progress,
                visit,
                veto=veto or _outranked(progress, leader, best / max(float(rate[place]), 1e-9)),
                leader=leader if veto is None and leader != row else -1,
                planned=when,
            )
        )
    return tuple(answers)


def _answer(
    progress: NightProgress, visit: Visit, *, veto: _Veto, leader: int, planned: int | None
) -> WhyNot:
    problem = progress.problem
    sentence = veto.words
    if veto.until is not None:
        sentence += f" until {clock_words(problem.unix(veto.until))}"
    elif veto.cause not in _AT_ANY_MOMENT:
        # For these a night without an end of the veto says something.
        sentence += ", and not again in this night"
    if planned is not None:
        sentence += f"; planned {clock_words(problem.unix(planned))}"
    return WhyNot(
        request=visit.id,
        cause=veto.cause,
        until=None if veto.until is None else problem.unix(veto.until),
        sentence=sentence,
        outranked_by=problem.table.visits[leader].id if leader >= 0 else "",
        planned_at=None if planned is None else problem.unix(planned),
    )


def clock_words(unix: float) -> str:
    """Give a time (s since the epoch, UTC) as hours and minutes."""
    minutes = round(unix / 60.0) % 1440
    return f"{minutes // 60:02d}:{minutes % 60:02d} UTC"


def _standing_veto(progress: NightProgress, second: int, row: int, visit: Visit) -> _Veto | None:
    """Give what holds whatever the sky is like."""
    table, limit = progress.problem.table, progress.problem.proposals[visit.proposal]
    if progress.done[row]:
        words = "it is complete" if progress.complete[row] else "it is no longer asked for"
        return _Veto(VetoCause.STATE, None, words)
    if visit.waits_for:
        return _Veto(VetoCause.ROOF, None, f"it is taken by itself, {visit.waits_for}")
    if visit.failures_reached:
        return _Veto(VetoCause.FAILURES, None, "it failed too often")
    left = limit.seconds_left - float(progress.used_s[visit.proposal])
    if table.block_s[row] > left + 1e-6:
        need = float(table.block_s[row]) / 60.0
        words = f"proposal {limit.id} has {left / 60.0:.0f} min left, it needs {need:.0f}"
        return _Veto(VetoCause.ALLOCATION, None, words)
    if progress.held_until[row] > second:
        held = int(progress.held_until[row])
        return _Veto(VetoCause.FAILURES, held, "it failed or was refused, and is tried again later")
    if not progress.are_released(np.array([row]))[0]:
        words = f"it comes after {visit.after}, which is not complete"
        return _Veto(VetoCause.SEQUENCE, None, words)
    if not progress.open and visit.needs_sky:
        why = f" ({progress.closed_why})" if progress.closed_why else ""
        return _Veto(VetoCause.ROOF, None, f"the roof is closed{why}")
    if "seeing" in progress.unread and visit.max_seeing < math.inf:
        words = f"nobody knows the seeing now, and it allows {visit.max_seeing:.1f}″"
        return _Veto(VetoCause.SEEING, None, words)
    if "clouds" in progress.unread and visit.max_clouds < math.inf:
        words = f"nobody knows how cloudy it is now, and it allows {visit.max_clouds:.0f} %"
        return _Veto(VetoCause.CLOUDS, None, words)
    if progress.seeing is not None and progress.seeing > visit.max_seeing:
        words = f"seeing is {progress.seeing:.1f}″, it allows {visit.max_seeing:.1f}″"
        return _Veto(VetoCause.SEEING, None, words)
    if progress.clouds is not None and progress.clouds > visit.max_clouds:
        words = f"{progress.clouds:.0f} % clouds, it allows {visit.max_clouds:.0f} %"
        return _Veto(VetoCause.CLOUDS, None, words)
    return None


def _sky_veto(
    progress: NightProgress, mark: int, visit: Visit, marks: Mapping[str, np.ndarray]
) -> _Veto | None:
    """Give the first constraint that forbids this minute, and when it ends."""
    second = mark * MARK_S
    if not any(begin <= second < end for begin, end in visit.windows):
        later = [begin for begin, _ in visit.windows if begin > second]
        words = "it is outside its window" if later else "its window is over"
        return _Veto(VetoCause.WINDOW, min(later) if later else None, words)
    sky = progress.problem.sky
    for name, mask in marks.items():
        if mask[mark]:
            continue
        # The mask is true where it may be observed, so its next true mark ends the veto.
        again = np.flatnonzero(mask[mark:])
        until = (mark + int(again[0])) * MARK_S if again.size else None
        match _MARK_CAUSES[name]:
            case VetoCause.SUN as cause:
                words = f"the Sun is at {sky.sun_altitude[mark]:.0f}°, too high"
            case VetoCause.ALTITUDE as cause:
                floor = max(visit.min_altitude, progress.problem.instrument.horizon)
                words = f"its target is below {floor:.0f}°"
            case VetoCause.AIRMASS as cause:
                words = f"its airmass is above {visit.max_airmass:.1f}"
            case VetoCause.MOON_ILLUMINATION as cause:
                lit = 100.0 * sky.moon_illumination[mark]
                words = f"the Moon is up, {lit:.0f} % lit"
            case VetoCause.MOON_DISTANCE as cause:
                words = f"the Moon is nearer than {visit.min_moon_distance:.0f}°"
            case VetoCause.HORIZON as cause:
                words = "its target is behind the horizon's outline"
            case VetoCause.HOUR_ANGLE as cause:
                words = f"it is more than {visit.max_hour_angle:.1f} h from the meridian"
            case cause:
                words = "its phase has not come"
        return _Veto(cause, until, words)
    return None


def _fit_veto(start: int, block_s: int) -> _Veto:
    minutes = block_s / 60.0
    words = f"its {minutes:.0f} min no longer fit before a constraint ends"
    return _Veto(VetoCause.DOES_NOT_FIT, start if start < NEVER else None, words)


def _outranked(progress: NightProgress, leader: int, factor: float) -> _Veto:
    # Equal within rounding: to name a leader would be a claim that the figures do not make.
    if leader < 0 or factor <= 1.0 + 1e-6:
        return _Veto(VetoCause.OUTRANKED, None, "allowed, and among the first now")
    name = progress.problem.table.visits[leader].id
    words = f"allowed, but {name} is worth {factor:.1f} times as much a minute"
    return _Veto(VetoCause.OUTRANKED, None, words)
