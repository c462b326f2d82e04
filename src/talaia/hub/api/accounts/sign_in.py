"""Signing in and out, and the first admin."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request, Response

from talaia.hub.api.access import address_of, alive_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.common import LoginAsk, Me, PermissionShape, SetupAsk
from talaia.hub.auth.passwords import check_name, check_password
from talaia.hub.auth.permissions import ANY, Right
from talaia.hub.errors import WeakPassword

if TYPE_CHECKING:
    from talaia.hub.api.accounts.authentication import Authentication
    from talaia.hub.api.accounts.browser_sessions import BrowserSessions
    from talaia.hub.auth.passwords import Passwords
    from talaia.hub.auth.permissions import Grants
    from talaia.hub.store.accounts.people import People
    from talaia.hub.store.accounts.sessions import LiveSession
    from talaia.hub.store.audit import Audit

__all__ = ["Accounts", "me_schema", "permissions_of"]


class Accounts:
    """The routes by which one comes in and goes out."""

    def __init__(
        self,
        *,
        proving: Authentication,
        sessions: BrowserSessions,
        people: People,
        passwords: Passwords,
        audit: Audit,
    ) -> None:
        """Sign in who has passed ``proving``."""
        self._proving = proving
        self._sessions = sessions
        self._people = people
        self._passwords = passwords
        self._audit = audit

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.post("/api/login")(self.login)
        router.post("/api/logout", status_code=204)(self.logout)
        router.post("/api/setup")(self.setup)
        router.get("/api/me")(self.me)
        return router

    async def login(self, asked: LoginAsk, request: Request, response: Response) -> Me:
        """Sign in. Wrong name and wrong password look alike, and take as long."""
        person = await self._proving.sign_in(request, asked.name, asked.password, asked.code)
        return await self._welcome_person(person.id, request, response, "login")

    async def setup(self, asked: SetupAsk, request: Request, response: Response) -> Me:
        """Make the first admin and sign in."""
        # No name of a person begins like this, so it is counted by address alone.
        ask = await self._proving.begin_attempt(request, f"\0setup from {address_of(request)}")
        # Looked at first: hashing a password for anybody who asks would keep cores busy.
        if not await self._people.may_set_up(asked.token):
            self._audit.append_record("setup refused", address=address_of(request), good=False)
            raise ApiProblem(403, "forbidden", "this set-up link is used up or too old")
        try:
            check_name(asked.name)
            check_password(asked.password, asked.name)
        except WeakPassword as error:
            raise ApiProblem(422, "invalid", str(error)) from error
        hashed = await self._passwords.hash_password(asked.password)
        user = await self._people.set_up(asked.token, asked.name, hashed)
        # Of two who had the link at once the other was quicker.
        if user is None:
            raise ApiProblem(403, "forbidden", "this set-up link is used up or too old")
        await self._proving.clear_attempt(ask)
        return await self._welcome_person(user, request, response, "setup")

    async def logout(self, request: Request, response: Response) -> None:
        """End the session; its open sockets are closed at once."""
        who = who_of(request)
        await self._sessions.sign_out(request, response)
        self._audit.append_record("logout", who=who.name, address=address_of(request))

    async def me(self, request: Request) -> Me:
        """Tell who is signed in, with which rights and until when."""
        return me_schema(alive_of(request))

    async def _welcome_person(
        self, user: int, request: Request, response: Response, kind: str
    ) -> Me:
        alive = await self._sessions.start_session(user, request, response)
        self._audit.append_record(kind, who=alive.who.name, address=address_of(request))
        return me_schema(alive)


def permissions_of(grants: Grants) -> list[PermissionShape]:
    """List permissions in one order: by site, device and right."""
    ordered = sorted(
        grants.permissions,
        # Right by how much it allows, not by its letters.
        key=lambda permission: (
            permission.site,
            permission.device,
            list(Right).index(permission.right),
        ),
    )
    return [
        PermissionShape(right=permission.right, site=permission.site, device=permission.device)
        for permission in ordered
    ]


def me_schema(alive: LiveSession) -> Me:
    """Write who is signed in."""
    who = alive.who
    return Me(
        name=who.name,
        role=who.role,
        admin=who.grants.has_right(Right.ADMIN, ANY),
        factor=who.factor,
        factor_missing=who.factor_missing,
        codes_locked_us=alive.codes_locked_us,
        password=alive.has_password,
        idle_ends_us=alive.idle_ends_us,
        ends_us=alive.ends_us,
        permissions=permissions_of(who.grants),
    )
