"""One's own account: password, sessions, second factor."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request, Response

from talaia.hub.api.access import address_of, alive_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.account_schemas import (
    CodeOnly,
    Confirmation,
    FactorOffer,
    PasswordChange,
    PasswordOnly,
    RecoveryCodes,
    RemoveFactor,
    SessionList,
    SessionShape,
)
from talaia.hub.auth.passwords import check_password
from talaia.hub.auth.totp import otp_uri, qr_svg
from talaia.hub.errors import PasskeyRefused, WeakPassword

if TYPE_CHECKING:
    from talaia.hub.api.accounts.authentication import Authentication
    from talaia.hub.api.accounts.browser_sessions import BrowserSessions
    from talaia.hub.api.accounts.passkey_answers import PasskeyAnswers
    from talaia.hub.auth.passwords import Passwords
    from talaia.hub.auth.permissions import Who
    from talaia.hub.store.accounts.mfa import SecondFactors
    from talaia.hub.store.accounts.people import People
    from talaia.hub.store.audit import Audit

__all__ = ["OwnPages"]


class OwnPages:
    """The routes of one's own account."""

    def __init__(
        self,
        *,
        proving: Authentication,
        sessions: BrowserSessions,
        people: People,
        passwords: Passwords,
        factors: SecondFactors,
        answers: PasskeyAnswers,
        audit: Audit,
    ) -> None:
        """Change what ``people`` and ``factors`` keep of who has passed ``proving``."""
        # Asks for the password again: whoever finds a page open must not get the account.
        self._proving = proving
        self._sessions = sessions
        self._people = people
        self._passwords = passwords
        self._factors = factors
        # Of passkeys, which confirm as well as a password and a code.
        self._answers = answers
        self._audit = audit

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.post("/api/me/confirm", status_code=204)(self.confirm)
        router.post("/api/me/password", status_code=204)(self.change_password)
        router.get("/api/me/sessions")(self.sessions)
        router.delete("/api/me/sessions", status_code=204)(self.end_sessions)
        router.delete("/api/me/sessions/{session}", status_code=204)(self.end_session)
        router.post("/api/me/factor")(self.offer_factor)
        router.post("/api/me/factor/confirm")(self.confirm_factor)
        router.post("/api/me/factor/remove", status_code=204)(self.remove_factor)
        router.post("/api/me/factor/seen", status_code=204)(self.see_alert)
        return router

    async def confirm(self, asked: Confirmation, request: Request) -> None:
        """Give your password anew, and your second factor: for minutes you may give rights away."""
        who = who_of(request)
        what = "confirmation refused"
        if asked.credential is not None:
            verified = await self._answers.confirm_answer(request, who, asked.credential)
            # The device has not asked who holds it: the password has to say so.
            if not verified:
                await self._proving.confirm_password(request, who.user, asked.password, what)
        elif who.factor:
            await self._proving.confirm_both(
                request, user=who.user, password=asked.password, code=asked.code, what=what
            )
        else:
            await self._proving.confirm_password(request, who.user, asked.password, what)
        self._sessions.confirm_session(who.session)
        self._append_record(request, "confirmed")

    async def change_password(
        self, asked: PasswordChange, request: Request, response: Response
    ) -> None:
        """Take another password; your other sessions and all your tokens end."""
        who = who_of(request)
        # The password stands in the question; the factor must have been given lately.
        if not alive_of(request).has_password:
            raise ApiProblem(
                409, "no_password", "you sign in by the provider; an admin can give you a password"
            )
        self._require_factor_lately(who)
        await self._proving.confirm_password(
            request, who.user, asked.old, "password change refused"
        )
        try:
            check_password(asked.new, who.name)
        except WeakPassword as error:
            raise ApiProblem(422, "invalid", str(error)) from error
        hashed = await self._passwords.hash_password(asked.new)
        await self._people.change_password(who.user, hashed, who.session)
        # No browser is known any more, but this one.
        await self._sessions.remember_browser(who.user, response)
        await self._sessions.follow_rights()
        self._append_record(request, "password changed")

    async def sessions(self, request: Request) -> SessionList:
        """List where you are signed in."""
        who = who_of(request)
        return SessionList(
            sessions=[
                SessionShape(**session._asdict(), this=session.id == who.session)
                for session in await self._sessions.list_open(who.user)
            ]
        )

    async def end_session(self, session: str, request: Request, response: Response) -> None:
        """End one of your sessions, here or elsewhere; its open sockets are closed at once."""
        if not await self._sessions.end_one(session, request, response):
            raise ApiProblem(404, "unknown", "you have no such session")
        self._append_record(request, "session ended")

    async def end_sessions(self, request: Request) -> None:
        """End all your sessions but this one."""
        who = who_of(request)
        await self._sessions.end_all(who.user, keep=who.session)
        self._append_record(request, "all other sessions ended")

    async def offer_factor(self, asked: PasswordOnly, request: Request) -> FactorOffer:
        """Begin a second factor. It is asked for once its first code has been confirmed."""
        who = who_of(request)
        # With a passkey there is a factor already, and it must have been given lately.
        self._require_factor_lately(who)
        await self._proving.confirm_password(
            request, who.user, asked.password, "second factor refused"
        )
        secret = await self._factors.offer_factor(who.user)
        if secret is None:
            raise ApiProblem(409, "taken", "you have a second factor already; remove it first")
        uri = otp_uri(secret, who.name)
        return FactorOffer(secret=secret, uri=uri, qr=qr_svg(uri))

    async def confirm_factor(self, asked: CodeOnly, request: Request) -> RecoveryCodes:
        """Switch the second factor on; your other sessions end."""
        who = who_of(request)
        # A code has six digits: without a count it could be found by trying.
        ask = await self._proving.begin_attempt(request, who.name)
        codes = await self._factors.confirm_factor(who.user, asked.code)
        if codes is None:
            raise ApiProblem(403, "factor", "the code is wrong, or no second factor was begun")
        await self._proving.clear_attempt(ask)
        # They were opened by the password alone.
        await self._sessions.end_all(who.user, keep=who.session)
        self._append_record(request, "second factor set")
        return RecoveryCodes(recovery=codes)

    async def remove_factor(self, asked: RemoveFactor, request: Request) -> None:
        """Sign in without codes from now on; passkeys stay."""
        who = who_of(request)
        what = "second factor removal refused"
        if not await self._factors.has_codes(who.user):
            raise ApiProblem(409, "missing", "you have no second factor with codes")
        await self._proving.confirm_both(
            request, user=who.user, password=asked.password, code=asked.code, what=what
        )
        try:
            await self._factors.remove_codes(who.user, keep_one=who.factor_required)
        except PasskeyRefused as error:
            raise ApiProblem(409, "required", str(error)) from error
        await self._sessions.follow_rights()
        self._append_record(request, "second factor removed")

    async def see_alert(self, request: Request) -> None:
        """Say that you have read that somebody tried codes for your account."""
        await self._factors.see_alert(who_of(request).user)

    def _require_factor_lately(self, who: Who) -> None:
        """Ask who has a second factor to have given it a short while ago.

        Raises:
            ApiProblem: 403 ``confirm``.

        """
        if who.factor and not self._sessions.is_confirmed(who.session):
            raise ApiProblem(403, "confirm", "confirm first that it is you: POST /api/me/confirm")

    def _append_record(self, request: Request, kind: str) -> None:
        self._audit.append_record(kind, who=who_of(request).name, address=address_of(request))
