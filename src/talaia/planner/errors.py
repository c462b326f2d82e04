"""What can be wrong with what a planner is asked."""

from __future__ import annotations

from talaia.errors import TalaiaError

__all__ = ["NotANight", "PlannerError", "UnknownRequest"]


class PlannerError(TalaiaError):
    """The planner cannot plan with this."""


class NotANight(PlannerError):
    """A night file, or a line of one, is not what the format says."""

    def __init__(self, where: str, problem: str, remedy: str = "") -> None:
        """Keep place, problem and remedy apart."""
        super().__init__(where, problem, remedy)
        self.where, self.problem, self.remedy = where, problem, remedy

    def __str__(self) -> str:
        tail = f"; {self.remedy}" if self.remedy else ""
        return f"{self.where}: {self.problem}{tail}"


class UnknownRequest(PlannerError):
    """An event names a request that the planner was never given."""

    def __init__(self, request: str) -> None:
        """Keep its id."""
        super().__init__(request)
        self.request = request

    def __str__(self) -> str:
        return f"no request {self.request!r} was given to the planner"
