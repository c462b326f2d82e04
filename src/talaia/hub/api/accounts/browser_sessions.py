"""The sessions of people's browsers: rows of the database, cookies and open sockets in step."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.access import address_of, who_of
from talaia.hub.store.safe_text import safe_text

if TYPE_CHECKING:
    from fastapi import Request, Response

    from talaia.hub.api.access import Access
    from talaia.hub.live.pages.session_registry import SocketSessions
    from talaia.hub.store.accounts.known_browsers import KnownBrowsers
    from talaia.hub.store.accounts.sessions import LiveSession, OpenSession, Sessions

__all__ = ["BrowserSessions"]


class BrowserSessions:
    """Begins and ends sessions; open sockets follow at once."""

    def __init__(
        self, *, access: Access, sessions: Sessions, browsers: KnownBrowsers, seats: SocketSessions
    ) -> None:
        """Keep sessions in ``sessions``; ``browsers`` are those known from earlier sign-ins."""
        # Makes the cookies.
        self._access = access
        self._sessions = sessions
        self._browsers = browsers
        # Sockets that are open: they end with their session, and follow a change of rights.
        self._seats = seats

    async def start_session(
        self, user: int, request: Request, response: Response, *, provider: bool = False
    ) -> LiveSession:
        """Begin a session for the browser that asks, in place of the one that it brought."""
        # A session that the browser brought is not the one that it leaves with.
        before = await self._access.identify_caller(request)
        # The one before ends, so that a session that somebody planted here is of no use (fixation).
        if before is not None and not before.who.script:
            await self._sessions.end_session(before.who.session)
            self._seats.end_session(before.who.session, "you have signed in anew")
        # Shown to the person in the list of sessions, so cut and cleaned.
        agent = safe_text(request.headers.get("user-agent", ""), 200)
        token, alive = await self._sessions.start_session(
            user, address_of(request), agent, provider=provider
        )
        self._access.set_cookie(response, token)
        known = request.cookies.get(self._access.browser_cookie, "")
        await self.remember_browser(user, response, known)
        return alive

    async def sign_out(self, request: Request, response: Response) -> None:
        """End the session of the browser that asks."""
        session = who_of(request).session
        # In the database first: a socket that dials again at once must find it ended.
        await self._sessions.end_session(session)
        self._seats.end_session(session, "you have signed out")
        self._access.clear_cookie(response)

    def confirm_session(self, session: str) -> None:
        """Its person has proved anew that it is them; see `Sessions`."""
        self._sessions.confirm_session(session)

    def is_confirmed(self, session: str) -> bool:
        """Tell whether they have, a short while ago."""
        return self._sessions.is_confirmed(session)

    async def list_open(self, user: int) -> list[OpenSession]:
        """List where a person is signed in."""
        return await self._sessions.sessions_of(user)

    async def end_one(self, session: str, request: Request, response: Response) -> bool:
        """End a session of the person who asks, this one or another; False: there is none."""
        who = who_of(request)
        # Of that person only: another's id is as if it were not there.
        if not session.isalnum() or not await self._sessions.end_of(who.user, session):
            return False
        self._seats.end_session(session, "you have ended this session")
        if session == who.session:
            self._access.clear_cookie(response)
        return True

    async def end_all(self, user: int, *, keep: str = "") -> None:
        """End all sessions of a person, but for the one to ``keep``."""
        await self._sessions.end_all(user, keep)
        await self._seats.follow()

    async def follow_rights(self) -> None:
        """Let open sockets follow a change of who may do what, at once."""
        await self._seats.follow()

    async def remember_browser(self, user: int, response: Response, known: str = "") -> None:
        """Let the browser be known at a later sign-in; ``known`` is what it was known by."""
        browser = await self._browsers.remember_browser(user, known)
        self._access.set_browser_cookie(response, browser)

    async def known_browser(self, request: Request, name: str) -> str:
        """Give by what the asking browser is known from sign-ins of ``name``; empty: it is not."""
        browser = request.cookies.get(self._access.browser_cookie, "")
        return browser if browser and await self._browsers.is_known(browser, name) else ""
