"""Signing in and out, and the first admin."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request, Response

from talaia.clock import SECOND
from talaia.hub.api.access import who_of
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.shapes import LoginAsk, Me, SetupAsk
from talaia.hub.auth.passwords import check_name, check_password, name_key
from talaia.hub.auth.permissions import ANY, Right
from talaia.hub.errors import WeakPassword

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.api.access import Access
    from talaia.hub.auth.passwords import Passwords
    from talaia.hub.auth.permissions import Who
    from talaia.hub.auth.throttle import Throttle
    from talaia.hub.live.seats import Seats
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.people import People
    from talaia.hub.store.sessions import Sessions

__all__ = ["Accounts"]

_WRONG = "name or password is wrong"


class Accounts:
    """The routes of accounts."""

    def __init__(
        self,
        access: Access,
        people: People,
        passwords: Passwords,
        sessions: Sessions,
        throttle: Throttle,
        seats: Seats,
        audit: Audit,
        clock: Clock,
    ) -> None:
        """Take the parts of an account."""
        self._access = access
        self._people = people
        self._passwords = passwords
        self._sessions = sessions
        self._throttle = throttle
        self._seats = seats
        self._audit = audit
        self._clock = clock

    def router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter()
        router.post("/api/login")(self.login)
        router.post("/api/logout", status_code=204)(self.logout)
        router.post("/api/setup")(self.setup)
        router.get("/api/me")(self.me)
        return router

    async def login(self, asked: LoginAsk, request: Request, response: Response) -> Me:
        """Sign in. Wrong name and wrong password look alike, and take as long."""
        key, address = name_key(asked.name), _address(request)
        now = self._clock.monotonic_ns()
        wait_ns = self._throttle.wait_ns(key, address, now)
        if wait_ns:
            raise ApiProblem(
                429, "busy", "too many wrong tries; wait a little", -(-wait_ns // SECOND)
            )
        self._throttle.tried(key, address, now)
        person = await self._people.find(asked.name)
        kept = person.password_hash if person and not person.disabled else None
        if not await self._passwords.verify(asked.password, kept) or person is None:
            self._audit.note("login failed", who=asked.name, address=address, good=False)
            raise ApiProblem(401, "wrong", _WRONG)
        self._throttle.succeeded(key, address)
        return await self._welcome(person.id, request, response, "login")

    async def setup(self, asked: SetupAsk, request: Request, response: Response) -> Me:
        """Make the first admin and sign in."""
        address = _address(request)
        now = self._clock.monotonic_ns()
        if self._throttle.wait_ns("", address, now):
            raise ApiProblem(429, "busy", "too many wrong tries; wait a little", 60)
        if not await self._people.may_set_up(asked.token):
            self._throttle.tried("", address, now)
            self._audit.note("setup refused", address=address, good=False)
            raise ApiProblem(403, "forbidden", "this set-up link is used up or too old")
        try:
            check_name(asked.name)
            check_password(asked.password)
        except WeakPassword as error:
            raise ApiProblem(422, "invalid", str(error)) from error
        hashed = await self._passwords.hash(asked.password)
        user = await self._people.set_up(asked.token, asked.name, hashed)
        if user is None:
            raise ApiProblem(403, "forbidden", "this set-up link is used up or too old")
        return await self._welcome(user, request, response, "setup")

    async def logout(self, request: Request, response: Response) -> None:
        """End the session; its open sockets are closed at once."""
        who = who_of(request)
        await self._sessions.end(who.session)
        self._seats.end_session(who.session, "you have signed out")
        self._access.clear_cookie(response)
        self._audit.note("logout", who=who.name, address=_address(request))

    async def me(self, request: Request) -> Me:
        """Tell who is signed in."""
        return _me(who_of(request))

    async def _welcome(self, user: int, request: Request, response: Response, kind: str) -> Me:
        address = _address(request)
        # A session that the browser brought is not the one that it leaves with.
        before = await self._access.who(request)
        if before is not None:
            await self._sessions.end(before.session)
            self._seats.end_session(before.session, "you have signed in anew")
        token, who = await self._sessions.begin(user, address)
        self._access.set_cookie(response, token)
        self._audit.note(kind, who=who.name, address=address)
        return _me(who)


def _me(who: Who) -> Me:
    return Me(name=who.name, role=who.role, admin=who.grants.may(Right.ADMIN, ANY))


def _address(request: Request) -> str:
    """Give the peer's address; headers of proxies are not believed."""
    return request.client.host if request.client else ""
