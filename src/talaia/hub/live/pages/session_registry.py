"""Everyone who has a socket open, and the end of their sessions within a second."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Protocol

from talaia.hub.errors import StoreDown

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from talaia.clock import Clock
    from talaia.hub.auth.permissions import Who
    from talaia.hub.settings import Settings
    from talaia.hub.store.accounts.sessions import LiveSession

__all__ = ["CredentialLookup", "SessionSocket", "SocketSessions"]

_LOG = logging.getLogger(__name__)
# A check that takes longer than this counts as failed (s).
_CHECK_S = 5.0
_OVER = "your session is over; sign in again"


class SessionSocket(Protocol):
    """A socket of a person."""

    who: Who

    def end(self, reason: str) -> None:
        """Tell the person and close; nothing else is sent from now on."""
        ...

    def tell_end(self, ends_us: int, *, idle: bool) -> None:
        """Tell the person when the session ends (UTC, µs); 0: it goes on after all."""
        ...

    def take_use(self) -> bool:
        """Tell whether the person has done something since this was last asked."""
        ...


class CredentialLookup(Protocol):
    """Who is signed in, by the database."""

    async def live_sessions(self, keys: Collection[str]) -> Mapping[str, LiveSession]:
        """Give those of the sessions and tokens that are alive, with their rights of now."""
        ...

    async def mark_used(self, used: Collection[LiveSession]) -> int:
        """Write down that sessions are used."""
        ...


class SocketSessions:
    """The open sockets of all people."""

    def __init__(self, register: CredentialLookup, clock: Clock, settings: Settings) -> None:
        """Ask ``register`` who is still signed in."""
        self._register = register
        # Monotonic for how old a check is, wall for the ends of sessions, which the database has.
        self._clock = clock
        # How long before its end a session is warned (µs).
        self._warn_us = round(min(settings.warn_s, settings.idle_s / 2) * 1e6)
        # So long after the last good check only STOP is passed on (ns).
        self._unsure_ns = round(settings.unsure_s * 1e9)
        # Open sockets of all people; one session may have several.
        self._seats: set[SessionSocket] = set()
        # Sockets that were told of the end, with the end they were told (UTC, µs).
        self._warned: dict[SessionSocket, int] = {}
        # The sessions of the last good check, by which sockets end while the database is away.
        self._last: Mapping[str, LiveSession] = {}
        # When the last good check began (monotonic); see `sure`.
        self._checked_ns = clock.monotonic_ns()

    @property
    def sure(self) -> bool:
        """Whether it was known a moment ago who may do what."""
        return self._clock.monotonic_ns() - self._checked_ns <= self._unsure_ns

    def add(self, seat: SessionSocket) -> None:
        """Take a seat in."""
        self._seats.add(seat)

    def remove(self, seat: SessionSocket) -> None:
        """Let a seat go."""
        self._seats.discard(seat)
        self._warned.pop(seat, None)

    def end_session(self, session: str, reason: str) -> None:
        """Close every socket of a session, at once."""
        # A copy: a socket that ends leaves the set.
        for seat in list(self._seats):
            if seat.who.session == session:
                seat.end(reason)

    def end_every(self, reason: str) -> None:
        """Close every socket."""
        for seat in list(self._seats):
            seat.end(reason)

    async def watch(self, every_s: float) -> None:
        """Hold the sockets against the sessions until cancelled.

        This finds what other processes did (the command line, another hub): a session ended,
        a person removed, a role or its permissions changed.
        """
        failing = False
        # Counted from here: nothing has been checked yet.
        self._checked_ns = self._clock.monotonic_ns()
        while True:
            await asyncio.sleep(every_s)
            try:
                # A database that hangs must not hold up the ends that time brings.
                async with asyncio.timeout(_CHECK_S):
                    await self.check()
            except (StoreDown, TimeoutError) as error:
                if not failing:
                    _LOG.error("sessions cannot be checked; commands are refused: %s", error)
                failing = True
                # What the database said last holds on: whoever would have ended by time ends.
                self._end_by_time()
            else:
                if failing:
                    _LOG.warning("sessions are checked again")
                failing = False

    async def follow(self) -> None:
        """Let the sockets follow a change of rights at once; `watch` does what fails here."""
        try:
            await self.check()
        except StoreDown as error:
            _LOG.warning("sockets follow a change of rights later: %s", error)

    async def check(self) -> None:
        """Close the sockets whose session is over or whose rights have changed.

        Raises:
            StoreDown: it cannot be told.

        """
        # When it began, not when it ended: rights may have changed during a slow answer.
        began_ns = self._clock.monotonic_ns()
        seats = list(self._seats)
        living = (
            await self._register.live_sessions({seat.who.session for seat in seats})
            if seats
            else {}
        )
        # Two may run at once; the one that began later counts.
        self._checked_ns = max(self._checked_ns, began_ns)
        self._last = living
        used = []
        for seat in seats:
            now = living.get(seat.who.session)
            if now is None:
                seat.end(_OVER)
            elif now.who != seat.who:
                # A new page has the new rights from the start; an open one may show what is not its
                # any more.
                seat.end("your rights have changed; the page loads again")
            else:
                self._warn(seat, now)
                if seat.take_use() and not now.who.script:
                    used.append(now)
        if used:
            await self._register.mark_used(used)

    def _warn(self, seat: SessionSocket, alive: LiveSession) -> None:
        """Tell, once, that the end is near; and once that it is not any more."""
        ends_us = min(alive.idle_ends_us, alive.ends_us)
        near = ends_us - self._now_us() <= self._warn_us
        # Another end is told anew: use may have moved it.
        if near and self._warned.get(seat) != ends_us:
            self._warned[seat] = ends_us
            seat.tell_end(ends_us, idle=alive.idle_ends_us < alive.ends_us)
        elif not near and self._warned.pop(seat, None) is not None:
            seat.tell_end(0, idle=False)

    def _end_by_time(self) -> None:
        """End what would have ended by now, while the database cannot say so."""
        for seat in list(self._seats):
            alive = self._last.get(seat.who.session)
            if alive is not None and min(alive.idle_ends_us, alive.ends_us) <= self._now_us():
                seat.end(_OVER)

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000
