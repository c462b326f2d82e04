"""Passkeys: sign in by one; make, list and remove one's own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request, Response

from talaia.hub.api.access import address_of, number_of, who_of
from talaia.hub.api.accounts.passkey_answers import relying_party
from talaia.hub.api.accounts.sign_in import me_schema
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.account_schemas import (
    PasskeyAdded,
    PasskeyAsk,
    PasskeyList,
    PasskeyName,
    PasskeyOptions,
    PasskeyOptionsAsk,
    PasskeyShape,
    PasskeySignIn,
)
from talaia.hub.api.schemas.common import Me  # noqa: TC001 - FastAPI reads it at run time
from talaia.hub.errors import PasskeyRefused
from talaia.hub.store.safe_text import safe_text

if TYPE_CHECKING:
    from talaia.hub.api.accounts.browser_sessions import BrowserSessions
    from talaia.hub.api.accounts.passkey_answers import PasskeyAnswers
    from talaia.hub.store.accounts.mfa import SecondFactors
    from talaia.hub.store.accounts.passkeys import Passkeys
    from talaia.hub.store.audit import Audit

__all__ = ["PasskeyPages"]


class PasskeyPages:
    """The routes of passkeys."""

    def __init__(
        self,
        *,
        answers: PasskeyAnswers,
        passkeys: Passkeys,
        factors: SecondFactors,
        sessions: BrowserSessions,
        audit: Audit,
    ) -> None:
        """Sign in by ``answers``; keep what is made in ``passkeys``."""
        self._answers = answers
        self._passkeys = passkeys
        # Knows who has codes besides.
        self._factors = factors
        self._sessions = sessions
        self._audit = audit

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.post("/api/login/passkey/options")(self.sign_in_options)
        router.post("/api/login/passkey")(self.sign_in)
        router.get("/api/me/passkeys")(self.overview)
        router.post("/api/me/passkeys")(self.add)
        router.post("/api/me/passkeys/options")(self.creation_options)
        router.post("/api/me/passkeys/challenge")(self.confirm_options)
        router.patch("/api/me/passkeys/{passkey}", status_code=204)(self.rename)
        router.delete("/api/me/passkeys/{passkey}", status_code=204)(self.remove)
        return router

    async def sign_in_options(self, asked: PasskeyOptionsAsk, request: Request) -> PasskeyOptions:
        """Begin to sign in by passkey: after name and password, or without both."""
        options = await self._answers.sign_in_options(request, asked.name, asked.password)
        return PasskeyOptions(options=options)

    async def sign_in(self, asked: PasskeySignIn, request: Request, response: Response) -> Me:
        """Sign in by the answer of a passkey."""
        user = await self._answers.sign_in(request, asked.credential)
        alive = await self._sessions.start_session(user, request, response)
        self._audit.append_record(
            "login", who=alive.who.name, address=address_of(request), message="passkey"
        )
        return me_schema(alive)

    async def overview(self, request: Request) -> PasskeyList:
        """List your passkeys."""
        user = who_of(request).user
        return PasskeyList(
            passkeys=[
                PasskeyShape(
                    id=str(passkey.id),
                    name=passkey.name,
                    host=passkey.host,
                    created_us=passkey.created_us,
                    used_us=passkey.used_us,
                )
                for passkey in await self._passkeys.passkeys_of(user)
            ],
            codes=await self._factors.has_codes(user),
            possible=relying_party(request).can_have_passkeys,
        )

    async def creation_options(self, request: Request) -> PasskeyOptions:
        """Begin to make a passkey."""
        return PasskeyOptions(
            options=await self._answers.creation_options(request, who_of(request))
        )

    async def add(self, asked: PasskeyAsk, request: Request) -> PasskeyAdded:
        """Keep a passkey that your browser has made; your other sessions end."""
        who, name = who_of(request), safe_text(asked.name, 200)
        key = await self._answers.created(request, who, asked.credential)
        try:
            number, recovery = await self._passkeys.add_passkey(
                who.user, name, relying_party(request).host, key
            )
        except PasskeyRefused as error:
            raise ApiProblem(409, "taken", str(error)) from error
        # They were opened without it.
        await self._sessions.end_all(who.user, keep=who.session)
        self._append_record(request, "passkey added", name)
        return PasskeyAdded(id=str(number), recovery=recovery)

    async def confirm_options(self, request: Request) -> PasskeyOptions:
        """Begin to confirm by a passkey that it is you; the answer goes to /api/me/confirm."""
        return PasskeyOptions(options=await self._answers.confirm_options(request, who_of(request)))

    async def rename(self, passkey: str, asked: PasskeyName, request: Request) -> None:
        """Call one of your passkeys otherwise."""
        name = safe_text(asked.name, 200)
        before = await self._passkeys.rename_passkey(
            who_of(request).user, number_of(passkey, "passkey"), name
        )
        if before is None:
            raise ApiProblem(404, "unknown", "you have no such passkey")
        self._append_record(request, "passkey renamed", f"{before} -> {name}")

    async def remove(self, passkey: str, request: Request) -> None:
        """Remove one of your passkeys."""
        who, number = who_of(request), number_of(passkey, "passkey")
        try:
            name = await self._passkeys.remove_passkey(
                who.user, number, keep_one=who.factor_required
            )
        except PasskeyRefused as error:
            raise ApiProblem(409, "required", str(error)) from error
        if name is None:
            raise ApiProblem(404, "unknown", "you have no such passkey")
        await self._sessions.follow_rights()
        self._append_record(request, "passkey removed", name)

    def _append_record(self, request: Request, kind: str, message: str) -> None:
        who = who_of(request).name
        self._audit.append_record(kind, who=who, address=address_of(request), message=message)
