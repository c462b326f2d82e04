"""People who come back from the provider: who they are here, what they may, and new ones."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.access import address_of
from talaia.hub.api.problems import ApiProblem
from talaia.hub.auth.id_tokens import verify_id_token
from talaia.hub.auth.passwords import check_name
from talaia.hub.errors import HubError, LastAdmin, NameTaken, ProviderRefused, WeakPassword
from talaia.hub.store.safe_text import safe_text

if TYPE_CHECKING:
    from fastapi import Request

    from talaia.clock import Clock
    from talaia.hub.auth.id_tokens import IdToken
    from talaia.hub.auth.oidc_states import AwaitedSignIn
    from talaia.hub.auth.provider_client import ProviderClient
    from talaia.hub.store.accounts.account_list import AccountList
    from talaia.hub.store.accounts.identities import Identities
    from talaia.hub.store.accounts.people import People
    from talaia.hub.store.audit import Audit

__all__ = ["OidcSignIn"]

# Clocks of two machines differ (s).
_SLACK_S = 60


class OidcSignIn:
    """Turns what the provider says into a person of this hub."""

    def __init__(
        self,
        *,
        provider: ProviderClient,
        identities: Identities,
        people: People,
        roster: AccountList,
        clock: Clock,
        audit: Audit,
    ) -> None:
        """Know people by ``identities``; new ones are added to ``people``."""
        self.provider = provider
        self._settings = provider.settings
        self._identities = identities
        self._people = people
        # Gives roles, and keeps one admin.
        self._roster = roster
        self._clock = clock
        self._audit = audit

    async def read_answer(
        self, request: Request, awaited: AwaitedSignIn, code: str, issuer: str
    ) -> IdToken:
        """Redeem a code for a token, and check it.

        Raises:
            ApiProblem: 403 ``provider``, it does not hold; the audit log says why.

        """
        try:
            # Another provider could have sent the browser here with a code of its own (mix-up).
            if issuer or await self.provider.requires_issuer():
                self._check_issuer(issuer)
            token, keys = await self.provider.redeem_code(code, awaited)
            return verify_id_token(
                token,
                keys,
                issuer=self._settings.issuer,
                client_id=self._settings.client_id,
                nonce=awaited.nonce,
                now_s=self._now_s(),
            )
        except ProviderRefused as error:
            raise self.refusal(request, str(error)) from error

    def refusal(self, request: Request, why: str) -> ApiProblem:
        """Write down why nobody is let in; give what is said to the browser."""
        self._audit.append_record(
            "login failed",
            address=address_of(request),
            message=safe_text(f"provider: {why}", 500),
            good=False,
        )
        return ApiProblem(403, "provider", why)

    async def find_person(self, request: Request, token: IdToken) -> tuple[int, bool]:
        """Give whom a token stands for, with the role that it gives, and whether they are new.

        Raises:
            ApiProblem: 403 ``provider``, they are not let in.

        """
        self._check_domain(request, token)
        settings = self._settings
        role = settings.role_of(token.words_of(settings.groups_claim))
        if not role:
            raise self.refusal(request, "you are in no group that may sign in here")
        known = await self._identities.person_of(settings.issuer, token.subject)
        try:
            if known is None:
                return await self._add_person(request, token, role), True
            user, disabled = known
            if disabled:
                raise self.refusal(request, "your account here is disabled")
            if settings.groups:
                await self._give_role(request, user, role)
        except HubError as error:
            raise self.refusal(request, str(error)) from error
        return user, False

    async def is_of(self, token: IdToken, user: int) -> bool:
        """Tell whether a token stands for a person."""
        known = await self._identities.person_of(self._settings.issuer, token.subject)
        return known is not None and known[0] == user

    def is_fresh(self, token: IdToken, awaited: AwaitedSignIn) -> bool:
        """Tell whether the password was given at the provider after this was begun."""
        age_s = (self._clock.monotonic_ns() - awaited.begun_ns) / 1e9
        return token.auth_time >= self._now_s() - age_s - _SLACK_S

    async def connect(self, request: Request, user: int, token: IdToken) -> None:
        """Let a person who is signed in come by the provider from now on.

        Raises:
            ApiProblem: 403 ``provider``, it is connected with somebody.

        """
        self._check_domain(request, token)
        try:
            await self._identities.connect(user, self._settings.issuer, token.subject)
        except NameTaken as error:
            raise self.refusal(request, str(error)) from error

    async def _add_person(self, request: Request, token: IdToken, role: str) -> int:
        if not self._settings.new_people:
            raise self.refusal(
                request, "no account here is connected with you; sign in and connect it first"
            )
        claim = self._settings.name_claim
        found = token.claims.get(claim)
        if not isinstance(found, str) or not found:
            raise self.refusal(request, f"the provider does not say what you are called ({claim})")
        try:
            check_name(found)
            # No hash: no password is right for them.
            user = await self._people.add_person(found, "", role)
        except WeakPassword as error:
            raise self.refusal(request, str(error)) from error
        except NameTaken as error:
            # A name is no proof: whoever may choose theirs at the provider would be admin here.
            raise self.refusal(
                request, f"{found} has an account here already; sign in and connect it"
            ) from error
        await self._identities.connect(user, self._settings.issuer, token.subject)
        self._append_record(request, "person added", found, f"{found} ({role}), by the provider")
        return user

    async def _give_role(self, request: Request, user: int, role: str) -> None:
        before = await self._roster.find_account(user)
        if before.role == role:
            return
        try:
            after = await self._roster.change_account(user, role=role)
        except LastAdmin as error:
            # Groups of elsewhere must not leave the hub without anybody who manages it.
            self._append_record(request, "role kept", before.name, str(error))
            return
        message = f"{before.name}: role {before.role} -> {after.role}, by the provider"
        self._append_record(request, "person changed", before.name, message)

    def _check_issuer(self, issuer: str) -> None:
        if issuer != self._settings.issuer:
            raise ProviderRefused(f"another provider has answered: {issuer[:200]!r}")

    def _check_domain(self, request: Request, token: IdToken) -> None:
        domains = self._settings.domains
        if not domains:
            return
        name, _, domain = token.verified_email.rpartition("@")
        if not name or domain.lower() not in domains:
            raise self.refusal(
                request, f"only verified mail addresses of {', '.join(domains)} are let in"
            )

    def _append_record(self, request: Request, kind: str, who: str, message: str) -> None:
        self._audit.append_record(
            kind, who=safe_text(who, 200), address=address_of(request), message=message
        )

    def _now_s(self) -> float:
        return self._clock.wall_ns() / 1e9
