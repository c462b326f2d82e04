"""Everyone who has a socket open, and the end of their sessions within a second."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Protocol

from sqlalchemy.exc import SQLAlchemyError

if TYPE_CHECKING:
    from talaia.hub.auth.permissions import Who
    from talaia.hub.store.sessions import Sessions

__all__ = ["Seat", "Seats"]

_LOG = logging.getLogger(__name__)


class Seat(Protocol):
    """A socket of a person."""

    who: Who

    def end(self, reason: str) -> None:
        """Tell the person and close; nothing else is sent from now on."""
        ...


class Seats:
    """The open sockets of all people."""

    def __init__(self, sessions: Sessions) -> None:
        """Ask ``sessions`` who is still signed in."""
        self._sessions = sessions
        self._seats: set[Seat] = set()

    def add(self, seat: Seat) -> None:
        """Take a seat in."""
        self._seats.add(seat)

    def remove(self, seat: Seat) -> None:
        """Let a seat go."""
        self._seats.discard(seat)

    def end_session(self, session: str, reason: str) -> None:
        """Close every socket of a session, at once."""
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
        while True:
            await asyncio.sleep(every_s)
            try:
                await self.check()
            except (SQLAlchemyError, OSError):
                if not failing:
                    _LOG.exception("sessions cannot be checked: the database does not answer")
                failing = True
            else:
                if failing:
                    _LOG.warning("sessions are checked again")
                failing = False

    async def check(self) -> None:
        """Close the sockets whose session is over or whose rights have changed."""
        if not self._seats:
            return
        seats = list(self._seats)
        living = await self._sessions.living({seat.who.session for seat in seats})
        for seat in seats:
            now = living.get(seat.who.session)
            if now is None:
                seat.end("your session is over; sign in again")
            elif now != seat.who:
                seat.end("your rights have changed; the page loads again")
