"""The simulated service that opens, closes, parks and stops the whole observatory."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.sim.observatory.models.ticket import Ticket
from talaia.sim.observatory.servers.base import Server

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.sim.observatory.servers.base import Value

__all__ = ["GlobalServer"]


class GlobalServer(Server):
    """The one service that moves all, by asking the others."""

    name = "observatory"
    # A step that takes longer is left behind: a dome closes even if the telescope does not park.
    WITHIN_S = 60.0

    def __init__(self, call: Callable[[str, str], Ticket], *, dome_turns: bool = True) -> None:
        """Take how another server is asked (its name, its service); one that turns is parked."""
        super().__init__()
        self._call = call
        # Of the sequence under way, for whoever asked for it.
        self._ticket = Ticket.done("")
        # What is left to do; the step under way is the first.
        self._steps: list[tuple[str, str]] = []
        # What came back for that step; none before it is asked for.
        self._under_way: Ticket | None = None
        # What it is doing, as its status says; empty for nothing.
        self._name = ""
        # For so long the step may still take (s).
        self._left = 0.0
        # What went wrong so far; the steps behind are done all the same.
        self._failed: list[str] = []
        self.triggers = {
            "status": lambda: Ticket.done(self._name or "idle"),
            "open": lambda: self._begin_sequence(
                "opening", ("dome", "open"), ("telescope", "unpark")
            ),
            "close": lambda: self._begin_sequence(
                "closing", ("camera", "abort"), ("telescope", "park"), ("dome", "close")
            ),
            "stop": self._stop_all,
        }
        # Only a roof that turns has a place to park at.
        park = [("camera", "abort"), ("telescope", "park"), *[("dome", "park")] * dome_turns]
        self.triggers["park"] = lambda: self._begin_sequence("parking", *park)

    def _begin_sequence(self, name: str, *steps: tuple[str, str]) -> Ticket:
        self._ticket.end_with("another command came", good=False)
        self._ticket, self._steps, self._name = Ticket(), list(steps), name
        self._under_way, self._failed = None, []
        return self._ticket

    def _stop_all(self) -> Ticket:
        self._ticket.end_with("the observatory was stopped", good=False)
        self._steps, self._name, self._under_way = [], "", None
        # Not waited for: a stop has to reach both.
        for device in ("dome", "telescope"):
            self._call(device, "stop")
        return Ticket.done("the observatory is stopped")

    def topic_values(self) -> Mapping[str, Value]:
        """Say what it does."""
        return {"status": self._name or "idle"}

    def step(self, seconds: float, unix_s: float) -> None:
        """Let time pass."""
        del unix_s
        if not self._name:
            return
        if self._under_way is not None:
            self._left -= seconds
            if not self._under_way.ended and self._left > 0:
                return
            if not self._under_way.good:
                said = self._under_way.message or "no answer"
                self._failed.append(f"{'/'.join(self._steps[0])}: {said}")
            self._steps.pop(0)
            self._under_way = None
        if self._steps:
            self._under_way = self._call(*self._steps[0])
            self._left = self.WITHIN_S
            return
        said = "; ".join(self._failed) or f"{self._name} is done"
        self._ticket.end_with(said, good=not self._failed)
        self._name = ""
