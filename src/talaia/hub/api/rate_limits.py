"""How much one person may ask at once, so that a program that runs wild slows nobody else down."""

from __future__ import annotations

from collections import Counter
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

from fastapi import Request  # noqa: TC002 - FastAPI reads it at run time

from talaia.clock import SECOND
from talaia.hub.api.access import who_of
from talaia.hub.api.problems import ApiProblem
from talaia.hub.auth.rate_limiter import RateLimiter
from talaia.hub.policy import AccessNeed, need_of_route

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from talaia.clock import Clock
    from talaia.hub.auth.permissions import Who

__all__ = ["MOST_SOCKETS", "RateLimits"]


class Rate(NamedTuple):
    """So many at once, and so many a second for long."""

    burst: int
    per_s: float


# A page of many charts asks for each of them when it is opened.
HISTORY = Rate(burst=300, per_s=30.0)
# Each reads much or all of a table.
HEAVY = Rate(burst=10, per_s=0.2)
# One of a long window keeps a core busy for seconds; a window that follows asks again and again.
OUTLIERS = Rate(burst=30, per_s=1.0)
# All that has no line below; a page asks for a dozen things when it is opened.
ANY = Rate(burst=600, per_s=100.0)
RATES: Mapping[str, Rate] = {
    "/api/sites/{site}/history": HISTORY,
    "/api/sites/{site}/last": HISTORY,
    "/api/sites/{site}/statistics": HISTORY,
    "/api/sites/{site}/outliers": OUTLIERS,
    "/api/sites/{site}/stored": HISTORY,
    "/api/sites/{site}/export": HEAVY,
    # A dashboard of many panels asks for each of them.
    "/clients/prometheus/read": HISTORY,
    "/api/storage": HEAVY,
    "/api/audit/export": HEAVY,
    # Each is a message that goes out, and a process.
    "/api/ways/{way}/test": HEAVY,
    "/api/me/rules/{rule}/test": HEAVY,
    "/api/sites/{site}/alarm-preview": HISTORY,
    "/api/audit/verify": HEAVY,
}
# Sockets of one person: open at once, and opened.
MOST_SOCKETS = 100
SOCKETS = Rate(burst=150, per_s=5.0)


class RateLimits:
    """Counts by person."""

    def __init__(self, clock: Clock) -> None:
        """Start with a clean slate."""
        self._clock = clock
        # Each route counts by itself: exports do not use up what charts may ask.
        self._paces = {route: RateLimiter(*rate) for route, rate in RATES.items()}
        self._any = RateLimiter(*ANY)
        self._opening = RateLimiter(*SOCKETS)
        # Sockets that are open now, by person; an entry goes with the last of them.
        self._open: Counter[int] = Counter()

    async def check_request(self, request: Request) -> None:
        """Let a request of a person pass the guard has let in.

        Raises:
            ApiProblem: 429 they have asked too much lately.

        """
        path = request.scope["route"].path
        # Nobody is known there; signing in and enrolling have counts of their own, by address.
        if need_of_route(request.method, path) is AccessNeed.OPEN:
            return
        self.count_request(path, who_of(request).user)

    def count_request(self, path: str, user: int) -> None:
        """Count a request of a person to a route.

        Raises:
            ApiProblem: 429 they have asked too much lately.

        """
        pace = self._paces.get(path, self._any)
        # By person and not by session or token: another one gives nobody more.
        wait_ns = pace.request_turn(user, self._clock.monotonic_ns())
        if wait_ns:
            # Rounded up: whoever comes a moment too early is refused again.
            raise ApiProblem(
                429, "busy", "you ask too much at once; wait a little", -(-wait_ns // SECOND)
            )

    @contextmanager
    def count_socket(self, who: Who) -> Iterator[bool]:
        """Count a socket while it is open; gives False when it is one too many."""
        allowed = (
            # How many, so that memory is bounded; how often, so that opening and closing is.
            self._open[who.user] < MOST_SOCKETS
            and self._opening.request_turn(who.user, self._clock.monotonic_ns()) == 0
        )
        if not allowed:
            yield False
            return
        self._open[who.user] += 1
        try:
            yield True
        finally:
            self._open[who.user] -= 1
            if not self._open[who.user]:
                del self._open[who.user]
