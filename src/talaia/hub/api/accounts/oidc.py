"""Sign in by a provider (OpenID Connect): to it, back from it, and what is done then."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter, Request, Response

from talaia.hub.api.access import address_of, number_of, who_of
from talaia.hub.api.accounts.passkey_answers import relying_party
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.account_schemas import (
    OidcAnswer,
    OidcConnection,
    OidcDone,
    OidcProvider,
    OidcReturn,
    OidcStart,
)
from talaia.hub.auth.oidc_states import OidcPurpose, OidcStates
from talaia.hub.auth.tokens import hash_token, new_token
from talaia.hub.errors import NoPassword, ProviderRefused, UnknownPerson

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.api.access import Access
    from talaia.hub.api.accounts.browser_sessions import BrowserSessions
    from talaia.hub.api.accounts.oidc_sign_in import OidcSignIn
    from talaia.hub.auth.id_tokens import IdToken
    from talaia.hub.auth.oidc_states import AwaitedSignIn
    from talaia.hub.auth.permissions import Who
    from talaia.hub.store.accounts.account_list import AccountList
    from talaia.hub.store.accounts.identities import Identities
    from talaia.hub.store.audit import Audit

__all__ = ["OidcPages"]

# Of the pages; the provider has to know it for this hub.
_BACK = "/oidc"
# So old may a sign-in be that confirms; what is asked of the provider (s).
_FRESH_S = 300


class OidcPages:
    """The routes of the provider. Without one they say that there is none."""

    def __init__(
        self,
        *,
        signing: OidcSignIn | None,
        access: Access,
        sessions: BrowserSessions,
        identities: Identities,
        roster: AccountList,
        clock: Clock,
        audit: Audit,
    ) -> None:
        """Let in whom ``signing`` finds; none: there is no provider."""
        self._signing = signing
        # Makes and reads cookies.
        self._access = access
        self._sessions = sessions
        # Also without a provider: who was connected with one of before.
        self._identities = identities
        self._roster = roster
        self._clock = clock
        self._audit = audit
        self._states = OidcStates()

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/login/oidc")(self.provider)
        router.post("/api/login/oidc")(self.begin_sign_in)
        router.post("/api/login/oidc/finish")(self.finish)
        router.post("/api/me/oidc/confirm")(self.begin_confirm)
        router.post("/api/me/oidc/connect")(self.begin_connect)
        router.get("/api/me/oidc")(self.connection)
        router.delete("/api/me/oidc", status_code=204)(self.disconnect)
        router.delete("/api/people/{person}/oidc", status_code=204)(self.disconnect_person)
        return router

    async def provider(self) -> OidcProvider:
        """Name the provider by which people sign in."""
        signing = self._signing
        return OidcProvider(label=signing.provider.settings.label if signing else "")

    async def begin_sign_in(
        self, asked: OidcReturn, request: Request, response: Response
    ) -> OidcStart:
        """Begin to sign in by the provider."""
        return await self._begin(OidcPurpose.SIGN_IN, asked, request, response)

    async def begin_confirm(
        self, asked: OidcReturn, request: Request, response: Response
    ) -> OidcStart:
        """Prove anew by the provider that it is you: it asks for your password there."""
        session = who_of(request).session
        return await self._begin(OidcPurpose.CONFIRM, asked, request, response, session=session)

    async def begin_connect(
        self, asked: OidcReturn, request: Request, response: Response
    ) -> OidcStart:
        """Let your account here be yours by the provider, too."""
        session = who_of(request).session
        return await self._begin(OidcPurpose.CONNECT, asked, request, response, session=session)

    async def connection(self, request: Request) -> OidcConnection:
        """Tell whether the provider signs you in."""
        return OidcConnection(connected=await self._identities.is_connected(who_of(request).user))

    async def disconnect(self, request: Request) -> None:
        """Let the provider sign you in no more; where you have a password. Other sessions end."""
        who = who_of(request)
        await self._disconnect(who.user)
        await self._sessions.end_all(who.user, keep=who.session)
        self._append_record(request, "account disconnected", who.name, "from the provider")

    async def disconnect_person(self, person: str, request: Request) -> None:
        """Let the provider sign a person in no more; where they have a password. Sessions end."""
        try:
            found = await self._roster.find_account(number_of(person, "person"))
        except UnknownPerson as error:
            raise ApiProblem(404, "unknown", str(error)) from error
        await self._disconnect(found.id)
        await self._sessions.end_all(found.id)
        message = f"{found.name}: disconnected from the provider"
        self._append_record(request, "person changed", who_of(request).name, message)

    async def _disconnect(self, user: int) -> None:
        try:
            if not await self._identities.disconnect(user):
                raise ApiProblem(409, "missing", "this account is not connected with the provider")
        except NoPassword as error:
            raise ApiProblem(409, "no_password", str(error)) from error

    async def finish(self, asked: OidcAnswer, request: Request, response: Response) -> OidcDone:
        """Come back from the provider: sign in, confirm, or connect."""
        signing = self._provided()
        browser = request.cookies.get(self._access.oidc_cookie, "")
        hashed = hash_token(browser) if browser else ""
        awaited = self._states.redeem(asked.state, hashed, self._clock.monotonic_ns())
        if awaited is None:
            raise signing.refusal(
                request, "this sign-in was begun in another browser, or too long ago; begin anew"
            )
        if asked.error or not asked.code:
            raise signing.refusal(request, f"the provider says: {asked.error or 'nothing'}")
        who = await self._check_session(request, awaited)
        token = await signing.read_answer(request, awaited, asked.code, asked.iss)
        if who is None:
            user, new = await signing.find_person(request, token)
            alive = await self._sessions.start_session(user, request, response, provider=True)
            # Of an account that is new nothing can have been left open for somebody else.
            if new or signing.is_fresh(token, awaited):
                self._sessions.confirm_session(alive.who.session)
            self._append_record(request, "login", alive.who.name, "by the provider")
        elif awaited.purpose is OidcPurpose.CONFIRM:
            await self._confirm(request, signing, awaited, token)
            self._append_record(request, "confirmed", who.name, "by the provider")
        else:
            await signing.connect(request, who.user, token)
            self._append_record(request, "account connected", who.name, "with the provider")
        return OidcDone(purpose=awaited.purpose.value, returns=awaited.returns)

    async def _begin(
        self,
        purpose: OidcPurpose,
        asked: OidcReturn,
        request: Request,
        response: Response,
        *,
        session: str = "",
    ) -> OidcStart:
        provider = self._provided().provider
        token = new_token()
        awaited = self._states.begin(
            purpose,
            self._clock.monotonic_ns(),
            browser=hash_token(token),
            redirect=f"{relying_party(request).origin}{_BACK}",
            returns=asked.returns,
            session=session,
        )
        fresh_s = 0 if purpose is OidcPurpose.SIGN_IN else _FRESH_S
        try:
            url = await provider.authorization_url(awaited, fresh_s=fresh_s)
        except ProviderRefused as error:
            raise ApiProblem(502, "provider", str(error)) from error
        self._access.set_oidc_cookie(response, token)
        return OidcStart(url=url)

    async def _check_session(self, request: Request, awaited: AwaitedSignIn) -> Who | None:
        """Give who has begun it; None for a sign-in.

        Raises:
            ApiProblem: 401, the session is over, or another's by now.

        """
        if awaited.purpose is OidcPurpose.SIGN_IN:
            return None
        alive = await self._access.identify_caller(request)
        if alive is None or alive.who.session != awaited.session:
            raise ApiProblem(401, "unauthorized", "sign in first")
        return alive.who

    async def _confirm(
        self, request: Request, signing: OidcSignIn, awaited: AwaitedSignIn, token: IdToken
    ) -> None:
        alive = await self._access.identify_caller(request)
        if alive is None or not await signing.is_of(token, alive.who.user):
            raise signing.refusal(request, "somebody else has signed in at the provider")
        if not token.auth_time:
            raise signing.refusal(
                request,
                "the provider does not say when you gave your password, so it confirms nothing;"
                " use a passkey of yours, or ask an admin to give you a password here",
            )
        if not signing.is_fresh(token, awaited):
            raise signing.refusal(request, "the provider did not ask for your password anew")
        self._sessions.confirm_session(awaited.session)

    def _provided(self) -> OidcSignIn:
        if self._signing is None:
            raise ApiProblem(404, "unknown", "this hub has no provider of sign-ins")
        return self._signing

    def _append_record(self, request: Request, kind: str, who: str, message: str) -> None:
        self._audit.append_record(kind, who=who, address=address_of(request), message=message)
