"""One night as arrays: what may be observed, with what, and who pays.

All times are whole seconds since the night's start (Sun at -6° in the evening), angles degrees.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from talaia.model.observing.plan import PauseRules

if TYPE_CHECKING:
    from talaia.model.observing.plan import Instrument
    from talaia.model.observing.requests import PhaseWindow
    from talaia.planner.sky import Floats, NightSky

__all__ = [
    "ANY_FILTER",
    "NEVER_COMPLETE",
    "NORMAL",
    "NO_VISIT_BEFORE",
    "RAPID",
    "TIME_CRITICAL",
    "FrameRun",
    "Ints",
    "NightProblem",
    "ParkPlace",
    "ProposalLimit",
    "Visit",
    "VisitTable",
]

Ints = NDArray[np.int64]

NORMAL, TIME_CRITICAL, RAPID = 0, 1, 2
# Longer than any night, and small enough for the arithmetic of starts (s).
_LONGEST_BLOCK_S = 1 << 27
# Whichever filter is in.
ANY_FILTER = -1
# Within this it is the same park (°).
_PARK_PLAY = 1.0
# In place of the row of the visit that comes before: there is none, or it is not here and so is
# never complete (it failed, expired or was cancelled before the night).
NO_VISIT_BEFORE, NEVER_COMPLETE = -1, -2


class FrameRun(NamedTuple):
    """Frames of one configuration: how many, and the time of each with its readout (s)."""

    frames: int
    frame_s: float
    # Before the first of them, beside what leads to the block: a change of filter (s).
    before_s: float = 0.0


class ParkPlace(NamedTuple):
    """Where a parked telescope points: altitude, and azimuth from north through east (°)."""

    altitude: float
    azimuth: float

    def is_far_from(self, other: ParkPlace) -> bool:
        """Tell whether it is another place, and not the same one read again."""
        turn = abs((self.azimuth - other.azimuth + 180.0) % 360.0 - 180.0)
        return max(turn, abs(self.altitude - other.altitude)) > _PARK_PLAY


class ProposalLimit(NamedTuple):
    """A proposal: its share of the shutter time (0 to 1), and what it may be charged tonight."""

    id: str
    share: float
    seconds_left: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Visit:
    """One visit, as it is asked for.

    Attributes:
        id: of its request.
        urgency: `NORMAL`, `TIME_CRITICAL` or `RAPID`.
        proposal: index into the problem's proposals.
        ra: right ascension (°, ICRS); of what moves: in the middle of the night.
        dec: declination (°, ICRS).
        track: directions at the sky's marks (3 × n) of what does not stand among the stars.
        tracked: false for what stands while the sky goes by.
        needs_sky: false for what the night takes without a plan; see ``waits_for``.
        waits_for: what that is taken in, in words (*in a twilight*); empty: it is planned.
        priority: worth of a minute of open shutter.
        shutter_s: open shutter in all (s).
        runs: frames that are still to be taken, by configuration.
        filters: indexes of the first and the last filter.
        angle: position angle that the camera is turned to (°); NaN: as it stands.
        windows: from when to when.
        arrives: when it was asked for.
        min_altitude: (°).
        max_airmass: secant of the zenith distance.
        min_moon_distance: while the Moon is up (°).
        max_moon_illumination: while the Moon is up (0 to 1).
        max_sun_altitude: (°).
        max_hour_angle: (h).
        max_seeing: (″).
        max_clouds: (%).
        phase: of a periodic object.
        after: id of the request that must be complete before.
        failures_reached: it failed too often.

    """

    id: str
    urgency: int = NORMAL
    proposal: int = 0
    ra: float = 0.0
    dec: float = 0.0
    track: Floats | None = None
    tracked: bool = True
    needs_sky: bool = True
    waits_for: str = ""
    priority: float = 10.0
    shutter_s: float = 0.0
    runs: tuple[FrameRun, ...] = ()
    filters: tuple[int, int] = (ANY_FILTER, ANY_FILTER)
    angle: float = np.nan
    windows: tuple[tuple[int, int], ...] = ()
    arrives: int = 0
    min_altitude: float = 0.0
    max_airmass: float = 40.0
    min_moon_distance: float = 0.0
    max_moon_illumination: float = 1.0
    max_sun_altitude: float = 0.0
    max_hour_angle: float = 12.0
    max_seeing: float = np.inf
    max_clouds: float = np.inf
    phase: PhaseWindow | None = None
    after: str = ""
    failures_reached: bool = False

    def block_s(self) -> int:
        """Give how long it takes, from the first exposure to the last readout (s)."""
        total = sum(run.frames * run.frame_s + run.before_s for run in self.runs)
        # What follows from two decimals of a second is no second more.
        return min(_LONGEST_BLOCK_S, int(np.ceil(round(total, 6))))


class VisitTable:
    """All visits of a night as columns, one row each; rows are only ever added."""

    def __init__(self, visits: tuple[Visit, ...] = ()) -> None:
        """Make the columns."""
        self.visits: list[Visit] = list(visits)
        self.index = {visit.id: row for row, visit in enumerate(self.visits)}
        self.ra = self._floats("ra")
        self.dec = self._floats("dec")
        self.priority = self._floats("priority")
        self.shutter_s = self._floats("shutter_s")
        self.value: Floats = self.priority * self.shutter_s / 60.0
        self.block_s: Ints = np.array([visit.block_s() for visit in self.visits], np.int64)
        self.proposal: Ints = np.array([visit.proposal for visit in self.visits], np.int64)
        self.urgency: Ints = np.array([visit.urgency for visit in self.visits], np.int64)
        self.arrives: Ints = np.array([visit.arrives for visit in self.visits], np.int64)
        self.filter_first: Ints = np.array([visit.filters[0] for visit in self.visits], np.int64)
        self.filter_last: Ints = np.array([visit.filters[1] for visit in self.visits], np.int64)
        self.angle = self._floats("angle")
        self.needs_sky: NDArray[np.bool_] = np.array(
            [visit.needs_sky for visit in self.visits], np.bool_
        )
        self.tracked: NDArray[np.bool_] = np.array(
            [visit.tracked for visit in self.visits], np.bool_
        )
        # Of the longest frames of each: between them a mount turns over.
        self.frame_s: Floats = np.array(
            [max((run.frame_s for run in visit.runs), default=0.0) for visit in self.visits]
        )
        self.after: Ints = np.array(
            [
                self.index.get(visit.after, NEVER_COMPLETE) if visit.after else NO_VISIT_BEFORE
                for visit in self.visits
            ],
            np.int64,
        )

    def __len__(self) -> int:
        return len(self.visits)

    def _floats(self, name: str) -> Floats:
        return np.array([getattr(visit, name) for visit in self.visits], np.float64)


@dataclass(kw_only=True)
class NightProblem:
    """A night, its telescope and what is asked of them.

    Attributes:
        start: (s since the epoch, UTC).
        length_s: to the Sun at -6° in the morning.
        sky: at its marks.
        instrument: what takes how long.
        pauses: what is done between exposures beside that.
        park: where the parked telescope points; none: nobody knows.
        resume: frames that were read out are kept when a block is interrupted.
        filters: names, by index.
        proposals: by index.
        table: the visits.

    """

    start: float
    length_s: int
    sky: NightSky
    instrument: Instrument
    pauses: PauseRules = field(default_factory=PauseRules)
    park: ParkPlace | None = None
    resume: bool = True
    filters: list[str] = field(default_factory=list)
    proposals: list[ProposalLimit] = field(default_factory=list)
    table: VisitTable = field(default_factory=VisitTable)

    def add_visits(self, visits: tuple[Visit, ...]) -> list[int]:
        """Add visits that are not there yet; gives the rows of the new ones."""
        new = tuple(visit for visit in visits if visit.id not in self.table.index)
        first = len(self.table)
        self.table = VisitTable((*self.table.visits, *new))
        return list(range(first, len(self.table)))

    def filter_index(self, name: str) -> int:
        """Give a filter's index; a new one is added."""
        if not name:
            return ANY_FILTER
        if name not in self.filters:
            self.filters.append(name)
        return self.filters.index(name)

    def unix(self, second: float) -> float:
        """Give a second of the night as seconds since the epoch (UTC)."""
        return self.start + second

    def second(self, unix: float) -> int:
        """Give a time (s since the epoch, UTC) as a whole second of the night."""
        return round(unix - self.start)
