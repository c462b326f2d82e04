"""Signing in and out, and the first admin."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request, Response

from talaia.hub.api.access import address_of, alive_of, who_of
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.shapes import LoginAsk, Me, PermissionShape, SetupAsk
from talaia.hub.auth.passwords import check_name, check_password
from talaia.hub.auth.permissions import ANY, Right
from talaia.hub.errors import WeakPassword
from talaia.hub.store.visible import visible

if TYPE_CHECKING:
    from talaia.hub.api.account_parts import AccountParts
    from talaia.hub.auth.permissions import Grants
    from talaia.hub.store.sessions import Alive

__all__ = ["Accounts", "permissions_of"]


class Accounts:
    """The routes by which one comes in and goes out."""

    def __init__(self, parts: AccountParts) -> None:
        """Take the parts of an account."""
        self._parts = parts

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
        person = await self._parts.proving.sign_in(request, asked.name, asked.password, asked.code)
        return await self._welcome(person.id, request, response, "login")

    async def setup(self, asked: SetupAsk, request: Request, response: Response) -> Me:
        """Make the first admin and sign in."""
        # No name of a person begins like this, so it is counted by address alone.
        ask = await self._parts.proving.begin(request, f"\0setup from {address_of(request)}")
        if not await self._parts.people.may_set_up(asked.token):
            self._parts.audit.note("setup refused", address=address_of(request), good=False)
            raise ApiProblem(403, "forbidden", "this set-up link is used up or too old")
        try:
            check_name(asked.name)
            check_password(asked.password, asked.name)
        except WeakPassword as error:
            raise ApiProblem(422, "invalid", str(error)) from error
        hashed = await self._parts.passwords.hash(asked.password)
        user = await self._parts.people.set_up(asked.token, asked.name, hashed)
        if user is None:
            raise ApiProblem(403, "forbidden", "this set-up link is used up or too old")
        await self._parts.proving.right(ask)
        return await self._welcome(user, request, response, "setup")

    async def logout(self, request: Request, response: Response) -> None:
        """End the session; its open sockets are closed at once."""
        who = who_of(request)
        await self._parts.sessions.end(who.session)
        self._parts.seats.end_session(who.session, "you have signed out")
        self._parts.access.clear_cookie(response)
        self._parts.audit.note("logout", who=who.name, address=address_of(request))

    async def me(self, request: Request) -> Me:
        """Tell who is signed in, with which rights and until when."""
        return _me(alive_of(request))

    async def _welcome(self, user: int, request: Request, response: Response, kind: str) -> Me:
        address = address_of(request)
        # A session that the browser brought is not the one that it leaves with.
        before = await self._parts.access.who(request)
        if before is not None and not before.who.script:
            await self._parts.sessions.end(before.who.session)
            self._parts.seats.end_session(before.who.session, "you have signed in anew")
        agent = visible(request.headers.get("user-agent", ""), 200)
        token, alive = await self._parts.sessions.begin(user, address, agent)
        self._parts.access.set_cookie(response, token)
        known = request.cookies.get(self._parts.access.browser_cookie, "")
        self._parts.access.set_browser_cookie(
            response, await self._parts.browsers.remember(user, known)
        )
        self._parts.audit.note(kind, who=alive.who.name, address=address)
        return _me(alive)


def permissions_of(grants: Grants) -> list[PermissionShape]:
    """List permissions in one order: by site, device and right."""
    ordered = sorted(
        grants.permissions, key=lambda each: (each.site, each.device, list(Right).index(each.right))
    )
    return [
        PermissionShape(right=each.right.value, site=each.site, device=each.device)
        for each in ordered
    ]


def _me(alive: Alive) -> Me:
    who = alive.who
    return Me(
        name=who.name,
        role=who.role,
        admin=who.grants.may(Right.ADMIN, ANY),
        factor=who.factor,
        idle_ends_us=alive.idle_ends_us,
        ends_us=alive.ends_us,
        permissions=permissions_of(who.grants),
    )
