"""Where signed heads of the audit log do not go now: told once, and once when they go again."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from talaia.hub.store.audit import Audit

__all__ = ["HeadTrouble"]

_LOG = logging.getLogger(__name__)


class HeadTrouble:
    """What is told of places for heads, in the log and, for an admin, in the audit log."""

    def __init__(self, audit: Audit, *, done: str = "sent") -> None:
        """Tell it to ``audit``; ``done`` is what becomes of the heads there."""
        self._audit = audit
        self._done = done
        # Where they do not go, and not yet again.
        self._failing: set[str] = set()

    def show(self, place: str, problem: str) -> None:
        """Tell that heads do not go somewhere, or, with an empty ``problem``, do again; once."""
        if problem and place not in self._failing:
            # By place: one that is away says nothing of the others.
            self._failing.add(place)
            _LOG.error("heads of the audit log were not %s to %s: %s", self._done, place, problem)
            message = f"{place}: {problem}"
            self._audit.append_record(f"heads not {self._done}", message=message, good=False)
        elif not problem and place in self._failing:
            self._failing.discard(place)
            _LOG.warning("heads of the audit log are %s to %s again", self._done, place)
            self._audit.append_record(f"heads {self._done} again", message=place)
