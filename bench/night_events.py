"""What a judge tells of a night, taken into the progress that a plain planner goes by."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import msgspec

from talaia.planner.night_file import NightRequest, make_visits

if TYPE_CHECKING:
    from talaia.planner.night_problem import NightProblem
    from talaia.planner.progress import NightProgress

__all__ = ["take_event"]


def take_event(problem: NightProblem, progress: NightProgress, event: dict[str, Any]) -> None:
    """Take requests that arrived, a release and an aborted block; others change nothing here."""
    if event["type"] == "arrived":
        requests = msgspec.convert(event["requests"], list[NightRequest])
        progress.add_visits(make_visits(problem, requests))
    elif event["type"] == "released":
        progress.pointing = None
    elif event["type"] == "aborted":
        row = problem.table.index[event["request"]]
        progress.shorten_visit(row, event["block_s"])
        progress.pointing = progress.pointing_at(row)
