"""Writes the scores of anomaly detectors to the history, as samples of channels of their own."""

from __future__ import annotations

import secrets
from typing import TYPE_CHECKING

import numpy as np
from sqlalchemy.exc import SQLAlchemyError

from talaia.errors import TalaiaError
from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from talaia.hub.ports import History

__all__ = ["ScoreWriter"]

# Of one site; more than these are dropped while the database is away.
_MOST_SCORES = 100_000
_FAILS = (SQLAlchemyError, TalaiaError, OSError)


class ScoreWriter:
    """Keeps scores until they are stored; the oldest stay when there is no room."""

    def __init__(self, history: History) -> None:
        """Begin a run of its own in ``history``."""
        self._history = history
        # Stands for a gateway's run: scores are numbered within it, so none is stored twice.
        self._run = f"scores-{secrets.token_hex(8)}"
        # What waits, by site: the score's address, its time (µs) and its value.
        self._waiting: dict[str, list[tuple[str, int, float]]] = {}
        # By site: the sequence number of the next score.
        self._first: dict[str, int] = {}

    def add_score(self, site: str, address: str, time_us: int, score: float) -> None:
        """Take a score; it is left out while too many wait."""
        waiting = self._waiting.setdefault(site, [])
        if len(waiting) < _MOST_SCORES:
            waiting.append((address, time_us, score))

    async def write_waiting(self) -> None:
        """Store what waits.

        Raises:
            SQLAlchemyError, TalaiaError, OSError: of a site, it is not stored; it goes on waiting.

        """
        failure: Exception | None = None
        for site in [site for site, waiting in self._waiting.items() if waiting]:
            # Swapped, so that scores that come during the write wait apart.
            waiting, self._waiting[site] = self._waiting[site], []
            addresses = tuple(dict.fromkeys(address for address, _, _ in waiting))
            place = {address: at for at, address in enumerate(addresses)}
            columns = Columns(
                np.array([place[address] for address, _, _ in waiting], np.uint16),
                np.array([time_us for _, time_us, _ in waiting], np.int64),
                np.array([score for _, _, score in waiting], np.float64),
                {},
            )
            first = self._first.get(site, 0)
            try:
                await self._history.append_samples(
                    site, self._run, first, addresses=addresses, columns=columns
                )
            except _FAILS as error:
                # Those that came meanwhile stand behind.
                self._waiting[site] = (waiting + self._waiting[site])[:_MOST_SCORES]
                # Others may be on a server that is there.
                failure = error
            else:
                # Only when they are stored: after a failure they keep their numbers.
                self._first[site] = first + len(waiting)
        if failure is not None:
            raise failure
