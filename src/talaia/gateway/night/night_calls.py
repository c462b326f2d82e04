"""Who is called when a night needs somebody, until it is armed anew or over."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.night.night_values import NightEvent

__all__ = ["NightCalls"]

# What calls somebody, by the kind of the event.
CALLS = frozenset({"night_fault", "night_not_closed", "night_not_parked"})


class NightCalls:
    """Hands on what calls somebody, and that it is over."""

    def __init__(self) -> None:
        """Have nobody to call yet."""
        self._callers: list[tuple[Callable[[str, str], None], Callable[[str], None]]] = []
        self._called: set[str] = set()

    def subscribe_calls(
        self, raised: Callable[[str, str], None], cleared: Callable[[str], None]
    ) -> None:
        """Have somebody called: with what it is about and why, and when that is over."""
        self._callers.append((raised, cleared))

    def call_for(self, event: NightEvent) -> None:
        """Call somebody, where an event is one that needs somebody."""
        if event.kind not in CALLS:
            return
        self._called.add(event.kind)
        for raised, _ in self._callers:
            raised(event.kind, event.message)

    def clear_calls(self) -> None:
        """Take in that a person has seen to it."""
        for kind in self._called:
            for _, cleared in self._callers:
                cleared(kind)
        self._called.clear()
