"""astroplan's `PriorityScheduler` as a planner of `bench/night.py`: it plans once, in the evening.

astroplan (BSD-3-Clause) is in no list of the product. For this bench, beside what is there:

    .venv/bin/pip install --no-deps -r requirements/bench.txt

It takes minutes for a hundred requests, so that it cannot plan anew at each event: what it planned
in the evening is observed in its order, and what weather or a rapid request leaves room for goes on
as long as it may. Nights of more than `MOST` requests are left out.
"""

from __future__ import annotations

import json
import warnings
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
from night_events import take_event

from talaia.planner.between.overheads import overheads_from
from talaia.planner.night_file import NightFile, make_problem
from talaia.planner.progress import NightProgress

if TYPE_CHECKING:
    from talaia.planner.night_problem import NightProblem

MOST = 150


def is_there() -> bool:
    """Tell whether astroplan can be imported."""
    try:
        import astroplan  # noqa: F401 - in no list of the product
    except ImportError:
        return False
    return True


class AstroplanOrder:
    """Observes what astroplan planned in the evening, in that order."""

    def answer_line(self, line: bytes) -> dict[str, object]:
        """Answer one line, as `talaia plan drive` does."""
        asked = json.loads(line)
        if asked["type"] == "night":
            night = msgspec.convert(asked["night"], NightFile)
            self._problem = make_problem(night)
            self._progress = NightProgress(self._problem)
            self._order = schedule_night(night, self._problem)
            return {}
        progress, table = self._progress, self._problem.table
        for name in asked.get("completed", []):
            progress.complete_visit(table.index[name])
        self._take_events(asked["events"])
        if asked["type"] == "interrupt":
            return {"interrupt": False}
        return self._decide(asked["t"])

    def _take_events(self, events: list[dict[str, Any]]) -> None:
        for event in events:
            take_event(self._problem, self._progress, event)
            if event["type"] == "aborted":
                row = self._problem.table.index[event["request"]]
                # What is left of it comes first, where it still may be observed.
                self._order.insert(0, (row, event["t"]))
            elif event["type"] == "refused":
                row = self._problem.table.index[event["request"]]
                self._order = [one for one in self._order if one[0] != row]

    def _decide(self, second: int) -> dict[str, object]:
        progress, table = self._progress, self._problem.table
        ready = set(progress.candidates(second).tolist())
        while self._order:
            row, planned = self._order[0]
            lead = int(overheads_from(self._problem, progress.pointing, np.array([row]), second)[0])
            start = max(planned, second + lead)
            may = row in ready and progress.feasibility.may_start(row, start)
            if not may:
                # It was planned for when the roof was closed, or others took longer.
                self._order.pop(0)
                continue
            if start - lead > second:
                return {"wait": start - lead}
            self._order.pop(0)
            return {"observe": table.visits[row].id, "not_before": start}
        return {"wait": self._problem.length_s}


def schedule_night(night: NightFile, problem: NightProblem) -> list[tuple[int, int]]:
    """Let astroplan plan a night; gives rows of visits with the seconds of their starts."""
    # Of the bench alone; they take a second to import.
    import astropy.units as u
    from astroplan import (
        AirmassConstraint,
        AltitudeConstraint,
        AtNightConstraint,
        FixedTarget,
        MoonSeparationConstraint,
        Observer,
        ObservingBlock,
        TimeConstraint,
    )
    from astroplan.scheduling import (
        PriorityScheduler,
        Schedule,
        TransitionBlock,
        Transitioner,
    )
    from astropy.coordinates import EarthLocation, SkyCoord
    from astropy.time import Time
    from astropy.utils import data, iers

    iers.conf.auto_download, iers.conf.auto_max_age = False, None
    data.conf.allow_internet = False
    warnings.filterwarnings("ignore")
    place = EarthLocation(
        lat=night.site.lat * u.deg, lon=night.site.lon * u.deg, height=night.site.elevation * u.m
    )
    observer, begin = Observer(location=place), Time(problem.start, format="unix", scale="utc")
    made = night.instrument
    blocks = []
    for request in night.requests:
        least = max(request.min_alt, made.horizon_deg) * u.deg
        constraints = [
            AltitudeConstraint(min=least, boolean_constraint=True),
            AirmassConstraint(max=request.max_airmass, boolean_constraint=True),
            AtNightConstraint(max_solar_altitude=request.sun_alt * u.deg),
        ]
        if request.moon_dist:
            constraints.append(MoonSeparationConstraint(min=request.moon_dist * u.deg))
        # It knows one window for a block: the longest.
        early, late = max(request.windows, key=lambda window: window[1] - window[0])
        constraints.append(TimeConstraint(begin + early * u.s, begin + late * u.s))
        target = FixedTarget(SkyCoord(request.ra * u.deg, request.dec * u.deg), name=request.id)
        blocks.append(
            ObservingBlock.from_exposures(
                target,
                # The smallest number comes first.
                1000.0 - request.priority,
                request.exp * u.s,
                request.n,
                made.readout_s * u.s,
                configuration={"filter": request.filter},
                constraints=constraints,
            )
        )
    change = {"default": made.filter_s * u.s}
    between = Transitioner(made.slew_deg_s * u.deg / u.s, {"filter": change})
    scheduler = PriorityScheduler(
        constraints=[], observer=observer, transitioner=between, time_resolution=60 * u.s
    )
    schedule = Schedule(begin, begin + night.end_s * u.s)
    scheduler(blocks, schedule)
    index = problem.table.index
    found = [
        (index[block.target.name], round((block.start_time - begin).sec))
        for block in schedule.scheduled_blocks
        if not isinstance(block, TransitionBlock)
    ]
    return sorted(found, key=lambda one: one[1])
