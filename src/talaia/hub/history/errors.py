"""The history could not be kept or read."""

from __future__ import annotations

from talaia.errors import TalaiaError

__all__ = ["HistoryError"]


class HistoryError(TalaiaError):
    """A batch was not stored, or a window could not be read.

    Nothing that `append` raised this for counts as stored: the gateway keeps it and sends it
    again, and what was stored after all is recognised by its sequence numbers.
    """

    def __init__(self, problem: str, remedy: str = "") -> None:
        """Keep what went wrong and what to do about it."""
        super().__init__(problem, remedy)
        self.problem = problem
        self.remedy = remedy

    def __str__(self) -> str:
        return f"history: {self.problem}" + (f"; {self.remedy}" if self.remedy else "")
