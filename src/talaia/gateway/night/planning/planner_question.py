"""What goes to the planner's process and what comes back. Pure.

A gateway without a night imports this, so no planner: that is in `planner_answers`.
"""

from __future__ import annotations

import msgspec

from talaia.model.observing.plan import (
    Instrument,
    PauseRules,
    Plan,
    WhyNot,
)
from talaia.model.observing.requests import Proposal, RequestGroup  # noqa: TC001 - msgspec reads them

__all__ = ["FocusNews", "PlannerAnswer", "PlannerQuestion", "PlannerSetup"]


class PlannerSetup(msgspec.Struct, frozen=True, kw_only=True, tag="setup"):
    """What is asked from here on, and of which telescope.

    Attributes:
        latitude: (°, north).
        longitude: (°, east).
        elevation: (m).
        instrument: how long it takes.
        pauses: what is done between exposures beside that.
        proposals: who pays.
        groups: what is asked.

    """

    latitude: float
    longitude: float
    elevation: float
    instrument: Instrument
    pauses: PauseRules = PauseRules()
    proposals: tuple[Proposal, ...] = ()
    groups: tuple[RequestGroup, ...] = ()


class FocusNews(msgspec.Struct, frozen=True, kw_only=True):
    """How it was focused last.

    Attributes:
        filter: through which.
        at: when (s since the epoch, UTC).
        every: the next run is due so long after it (s).
        again: why then, in words.

    """

    filter: str
    at: float
    every: float
    again: str = ""


class PlannerQuestion(msgspec.Struct, frozen=True, kw_only=True, tag="question"):
    """What to observe next.

    Attributes:
        number: the answer has the same.
        time: s since the epoch (UTC).
        done: frames of each configuration, by request.
        ended: requests that are done.
        held: requests that are left alone, until (s since the epoch, UTC).
        charged: what each proposal was charged beyond the hours of the setup (s).
        seeing: FWHM (″).
        clouds: (%).
        unread: which of both should be measured and says nothing; see `NightView`.
        parked: the telescope is.
        park: where it then points: altitude, azimuth (°); none: nobody knows.
        focus: the last focus run; none: there was none.

    """

    number: int
    time: float
    done: dict[str, tuple[int, ...]] = {}
    ended: tuple[str, ...] = ()
    held: dict[str, float] = {}
    charged: dict[str, float] = {}
    seeing: float | None = None
    clouds: float | None = None
    unread: frozenset[str] = frozenset()
    parked: bool = False
    park: tuple[float, float] | None = None
    focus: FocusNews | None = None


class PlannerAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """What the planner says.

    Attributes:
        number: of the question.
        request: to be observed now; empty: wait.
        wait_until: ask again then (s since the epoch, UTC).
        reason: in words.
        plan: from now on.
        why_not: of those that wait.

    """

    number: int
    request: str = ""
    wait_until: float = 0.0
    reason: str = ""
    plan: Plan | None = None
    why_not: tuple[WhyNot, ...] = ()
