"""Tokens by which a person's scripts sign in."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request

from talaia.hub.api.access import address_of, number_of, who_of
from talaia.hub.api.accounts.roles import in_words, read_permissions
from talaia.hub.api.accounts.sign_in import permissions_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.account_schemas import NewToken, TokenAsk, TokenList, TokenShape
from talaia.hub.auth.passwords import check_name
from talaia.hub.auth.permissions import Right
from talaia.hub.errors import WeakPassword
from talaia.hub.store.accounts.tokens import MOST

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.live.pages.session_registry import SocketSessions
    from talaia.hub.store.accounts.tokens import ApiTokens
    from talaia.hub.store.audit import Audit

__all__ = ["TokenPages"]

# A year, also one with a leap day (µs).
_LONGEST_US = 366 * 86_400 * 1_000_000


class TokenPages:
    """The routes of tokens."""

    def __init__(
        self, tokens: ApiTokens, seats: SocketSessions, audit: Audit, clock: Clock
    ) -> None:
        """Work on ``tokens``; the sockets of one that is revoked are closed at once."""
        self._tokens = tokens
        self._seats = seats
        self._audit = audit
        self._clock = clock

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/me/tokens")(self.overview)
        router.post("/api/me/tokens")(self.add)
        router.delete("/api/me/tokens/{token}", status_code=204)(self.remove)
        return router

    async def overview(self, request: Request) -> TokenList:
        """List your tokens that have not ended."""
        return TokenList(
            tokens=[
                TokenShape(
                    id=str(token.id),
                    name=token.name,
                    permissions=permissions_of(token.grants),
                    created_us=token.created_us,
                    ends_us=token.ends_us,
                    used_us=token.used_us,
                )
                for token in await self._tokens.tokens_of(who_of(request).user)
            ]
        )

    async def add(self, asked: TokenAsk, request: Request) -> NewToken:
        """Make a token with some of your rights, until a date within a year. It is shown once."""
        who = who_of(request)
        try:
            check_name(asked.name)
        except WeakPassword as error:
            raise ApiProblem(422, "invalid", str(error)) from error
        # The wall's clock: the end is a date, and holds over restarts.
        now_us = self._clock.wall_ns() // 1000
        if not now_us < asked.ends_us <= now_us + _LONGEST_US:
            raise ApiProblem(422, "invalid", "a token ends after now and within a year")
        wanted = read_permissions(asked.permissions)
        for permission in wanted:
            # A script's token lies in some file: it must not be able to make people or roles.
            if permission.right is Right.ADMIN:
                raise ApiProblem(422, "invalid", "a token cannot manage; take view or use")
            if not who.grants.covers(permission):
                raise ApiProblem(
                    403, "forbidden", f"you do not have {in_words([permission])} yourself"
                )
        made = await self._tokens.add_token(who.user, asked.name, asked.ends_us, wanted)
        if made is None:
            raise ApiProblem(409, "busy", f"you have {MOST} tokens; revoke some first")
        self._append_record(request, "token made", f"{asked.name}: {in_words(wanted)}")
        return NewToken(id=str(made[0]), token=made[1])

    async def remove(self, token: str, request: Request) -> None:
        """Revoke a token; its open sockets are closed at once."""
        name = await self._tokens.revoke_token(who_of(request).user, number_of(token, "token"))
        if name is None:
            raise ApiProblem(404, "unknown", "you have no such token")
        # Sockets that it opened are closed.
        await self._seats.follow()
        self._append_record(request, "token revoked", name)

    def _append_record(self, request: Request, kind: str, message: str) -> None:
        who = who_of(request).name
        self._audit.append_record(kind, who=who, address=address_of(request), message=message)
