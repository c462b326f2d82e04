"""What the planner does while nobody asks: it looks again, and more widely each time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.planner.search import IDLE

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.planner.beam_search import OrderedVisit
    from talaia.planner.progress import NightProgress
    from talaia.planner.search import NightSearch

__all__ = ["IdleRounds"]


class IdleRounds:
    """Searches what follows on the newest decision, a bounded number of times."""

    def __init__(self, progress: NightProgress, search: NightSearch) -> None:
        """Begin with no decision."""
        self._progress, self._search = progress, search
        # So many since something has happened.
        self._rounds = 0
        # When was decided last, and what is observed meanwhile.
        self._decided = 0
        self._meanwhile: OrderedVisit | None = None

    def note_decision(self, second: int, *, changed: bool) -> None:
        """Look after this decision; rounds count anew where something has ``changed``."""
        self._decided, self._meanwhile = second, None
        if changed:
            self._rounds = 0

    def note_visit(self, step: OrderedVisit) -> None:
        """Take it that this visit is what the decision leads to."""
        self._meanwhile = step

    def search_once(self, stopped: Callable[[], bool]) -> bool:
        """Search one round; see `PlanningSession.improve_idle`."""
        if self._rounds >= len(IDLE) or not self._progress.open:
            return False
        step, since, effort = self._meanwhile, self._decided, IDLE[self._rounds]
        if step is None:
            # Nothing may be observed now, or what may be is waited for.
            self._search.improve_rest(since, effort, since=since, stopped=stopped)
        else:
            # As it will stand when that visit has been observed.
            with self._progress.assume_observed(step.row):
                self._search.improve_rest(step.end, effort, since=since, stopped=stopped)
            self._search.lead_with(step)
        # One that was stopped has found nothing, and is made again.
        self._rounds += not stopped()
        return self._rounds < len(IDLE)
