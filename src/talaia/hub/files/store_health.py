"""Whether an object store is well: a loss is logged once, and so is the recovery."""

from __future__ import annotations

import logging
from enum import Enum

__all__ = ["StoreHealth", "StoreUse"]

_LOG = logging.getLogger(__name__)


class StoreUse(Enum):
    """What is asked of a store; one that is full still gives what it has."""

    READ = "read"
    WRITE = "written"


class StoreHealth:
    """What a store did last; whoever asks it reports here, from any thread."""

    def __init__(self, place: str) -> None:
        """Speak of the store at ``place``."""
        self._place = place
        # Why, by what was asked; while all is well there is nothing.
        self._troubles: dict[StoreUse, str] = {}
        # A store that is full is well again once it takes a file, not before.
        self.full = False

    @property
    def trouble(self) -> str:
        """Why the store does not do what it should; empty while it does."""
        return next(iter(self._troubles.values()), "")

    def troubled(self, use: StoreUse) -> bool:
        """Tell whether it failed when this was asked of it last."""
        return use in self._troubles

    def report_failure(self, use: StoreUse, why: str, *, full: bool = False) -> None:
        """Say that it did not do it, and why."""
        self.full = self.full or full
        # Once, however many ask meanwhile and whatever it says then.
        if use not in self._troubles:
            _LOG.error("the store of files %s %s; nothing is %s", self._place, why, use.value)
        self._troubles[use] = f"the store of files {why}"

    def report_success(self, use: StoreUse) -> None:
        """Say that it did it."""
        if use is StoreUse.WRITE:
            self.full = False
        if self._troubles.pop(use, None) is not None:
            _LOG.warning("files of %s are %s again", self._place, use.value)
