"""Commands of a night that open or unpark, and may still do so. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.night.night_values import NightCommand
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Iterable, Set

    from talaia.gateway.night.night_values import NightAction, StepAnswer

__all__ = ["GUARD_S", "UnendedCommands"]

# The roof's guard has so long, beside its own times, before the night closes by itself (s).
GUARD_S = 10.0


class UnendedCommands:
    """Which of some commands were asked for and may not have ended."""

    def __init__(self, names: Set[str]) -> None:
        """Follow the commands of these names."""
        self._names = names
        # By id: which, and until when at the longest (monotonic, s).
        self._asked: dict[str, tuple[str, float]] = {}

    def add_asked(self, actions: Iterable[NightAction], now: float) -> None:
        """Take in what is asked for now (monotonic, s)."""
        for ask in actions:
            if isinstance(ask, NightCommand) and ask.command in self._names:
                self._asked[ask.id] = ask.command, now + ask.within + GUARD_S

    def take_answer(self, answer: StepAnswer) -> None:
        """Take how a command ended; one of which that is not known may still do something."""
        if answer.phase is not CommandPhase.UNKNOWN:
            self._asked.pop(answer.id, None)

    def under_way(self, now: float) -> set[str]:
        """Give the names of those that may not have ended."""
        return {name for name, until in self._asked.values() if now < until}

    def forget_all(self) -> None:
        """Take them as ended: what they do was undone, and the sensors say so."""
        self._asked.clear()
