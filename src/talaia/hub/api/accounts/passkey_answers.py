"""Challenges for people's passkeys, and their answers held against what is kept."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from talaia.hub.api.access import address_of
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.server.request_guard import host_name
from talaia.hub.auth.passkey_ceremony import (
    RegisteredPasskey,
    RelyingParty,
    challenge_of,
    creation_options,
    request_options,
    verify_answer,
    verify_registration,
)
from talaia.hub.auth.passkey_challenges import ChallengeUse
from talaia.hub.errors import PasskeyRefused

if TYPE_CHECKING:
    from collections.abc import Mapping

    from fastapi import Request

    from talaia.clock import Clock
    from talaia.hub.api.accounts.authentication import Authentication
    from talaia.hub.auth.passkey_challenges import PasskeyChallenge, PasskeyChallenges
    from talaia.hub.auth.permissions import Who
    from talaia.hub.store.accounts.passkeys import KeptPasskey, Passkeys
    from talaia.hub.store.audit import Audit

__all__ = ["PasskeyAnswers", "relying_party"]

_SIGN_IN = frozenset({ChallengeUse.SECOND_FACTOR, ChallengeUse.PASSWORDLESS})


class PasskeyAnswers:
    """Asks passkeys, and checks what they answer; wrong answers are counted as wrong sign-ins."""

    def __init__(
        self,
        *,
        passkeys: Passkeys,
        challenges: PasskeyChallenges,
        proving: Authentication,
        clock: Clock,
        audit: Audit,
    ) -> None:
        """Hand out ``challenges``; what answers is in ``passkeys``."""
        self._passkeys = passkeys
        self._challenges = challenges
        # Counts tries.
        self._proving = proving
        # Monotonic, for how old a challenge is.
        self._clock = clock
        self._audit = audit

    async def sign_in_options(self, request: Request, name: str, password: str) -> dict[str, Any]:
        """Begin a sign-in: as a second factor after name and password, or without both.

        Raises:
            ApiProblem: 401 ``wrong``, 409 ``no_passkey``, 429 ``busy``.

        """
        address = _usable_address(request)
        if not name:
            challenge = self._begin(ChallengeUse.PASSWORDLESS)
            return request_options(address, challenge, known=(), verified=True)
        # Only after the password: else anybody could ask who has passkeys.
        person = await self._proving.check_first_half(request, name, password)
        known = await self._ids_of(person.id, address)
        if not known:
            raise ApiProblem(409, "no_passkey", f"you have no passkey for {address.host}")
        challenge = self._begin(ChallengeUse.SECOND_FACTOR, user=person.id)
        return request_options(address, challenge, known=known, verified=False)

    async def sign_in(self, request: Request, credential: Mapping[str, Any]) -> int:
        """Check the answer of a sign-in; give whose it is.

        Raises:
            ApiProblem: 401 ``factor``, 429 ``busy``.

        """
        # As a wrong password is: by the person whose key it says it is, else by the address.
        said = await self._passkeys.find_passkey(str(credential.get("id", "")))
        name = said.owner if said else f"\0passkey from {address_of(request)}"
        ask = await self._proving.begin_attempt(request, name)
        kept, _ = await self._check_answer(request, credential, uses=_SIGN_IN, status=401)
        await self._proving.clear_attempt(ask)
        return kept.user

    async def confirm_options(self, request: Request, who: Who) -> dict[str, Any]:
        """Ask a person who is signed in for one of their passkeys.

        Raises:
            ApiProblem: 409 ``no_passkey``.

        """
        address = _usable_address(request)
        known = await self._ids_of(who.user, address)
        if not known:
            raise ApiProblem(409, "no_passkey", f"you have no passkey for {address.host}")
        challenge = self._begin(ChallengeUse.CONFIRM, user=who.user, session=who.session)
        return request_options(address, challenge, known=known, verified=False)

    async def confirm_answer(
        self, request: Request, who: Who, credential: Mapping[str, Any]
    ) -> bool:
        """Check that answer; tell whether the passkey's device has verified the person.

        Raises:
            ApiProblem: 403 ``factor``, 429 ``busy``.

        """
        ask = await self._proving.begin_attempt(request, who.name)
        uses = frozenset({ChallengeUse.CONFIRM})
        _, verified = await self._check_answer(
            request, credential, uses=uses, status=403, session=who.session
        )
        await self._proving.clear_attempt(ask)
        return verified

    async def creation_options(self, request: Request, who: Who) -> dict[str, Any]:
        """Begin to make a passkey.

        Raises:
            ApiProblem: 409 ``no_name``: browsers make none for an IP address.

        """
        address = _usable_address(request)
        challenge = self._begin(ChallengeUse.REGISTER, user=who.user, session=who.session)
        have = await self._ids_of(who.user, address)
        return creation_options(address, challenge, user=who.user, name=who.name, have=have)

    async def created(
        self, request: Request, who: Who, credential: Mapping[str, Any]
    ) -> RegisteredPasskey:
        """Check what the browser has made.

        Raises:
            ApiProblem: 422 ``invalid``.

        """
        try:
            waited = self._redeem(
                credential, frozenset({ChallengeUse.REGISTER}), session=who.session
            )
            return verify_registration(relying_party(request), waited.value, credential)
        except PasskeyRefused as error:
            raise ApiProblem(422, "invalid", str(error)) from error

    async def _check_answer(
        self,
        request: Request,
        credential: Mapping[str, Any],
        *,
        uses: frozenset[ChallengeUse],
        status: int,
        session: str = "",
    ) -> tuple[KeptPasskey, bool]:
        """Hold an answer against its challenge and its key.

        Raises:
            ApiProblem: ``status`` ``factor``.

        """
        try:
            waited = self._redeem(credential, uses, session=session)
            kept = await self._find_asked(waited, credential)
            verified = await self._use_passkey(request, waited, kept, credential)
        except PasskeyRefused as error:
            what = "login failed" if status == 401 else "confirmation refused"
            self._audit.append_record(
                what, address=address_of(request), message=f"passkey: {error.problem}", good=False
            )
            raise ApiProblem(status, "factor", str(error)) from error
        return kept, verified

    async def _find_asked(
        self, waited: PasskeyChallenge, credential: Mapping[str, Any]
    ) -> KeptPasskey:
        kept = await self._passkeys.find_passkey(str(credential.get("id", "")))
        # Another's passkey is as wrong as none, whoever has it.
        if kept is None or waited.user not in {0, kept.user}:
            raise PasskeyRefused("this passkey is not known here", "use another")
        return kept

    async def _use_passkey(
        self,
        request: Request,
        waited: PasskeyChallenge,
        kept: KeptPasskey,
        credential: Mapping[str, Any],
    ) -> bool:
        count, verified = verify_answer(
            relying_party(request),
            waited.value,
            credential,
            kept=kept.key,
            verified=waited.use is ChallengeUse.PASSWORDLESS,
        )
        if not await self._passkeys.mark_passkey_used(kept, count):
            raise PasskeyRefused("this answer was used already", "try again")
        return verified

    async def _ids_of(self, user: int, address: RelyingParty) -> list[str]:
        found = await self._passkeys.passkeys_of(user)
        return [passkey.key.credential_id for passkey in found if passkey.host == address.host]

    def _begin(self, use: ChallengeUse, *, user: int = 0, session: str = "") -> bytes:
        return self._challenges.begin(use, self._clock.monotonic_ns(), user=user, session=session)

    def _redeem(
        self, credential: Mapping[str, Any], uses: frozenset[ChallengeUse], *, session: str
    ) -> PasskeyChallenge:
        now_ns = self._clock.monotonic_ns()
        found = self._challenges.redeem(challenge_of(credential), uses, now_ns, session)
        if found is None:
            raise PasskeyRefused("this was begun elsewhere, or too long ago", "begin anew")
        return found


def relying_party(request: Request) -> RelyingParty:
    """Give the hub's address as the browser has it; the guard has held the name against its own."""
    host = request.headers["host"]
    return RelyingParty(host_name(host), f"{request.url.scheme}://{host}")


def _usable_address(request: Request) -> RelyingParty:
    address = relying_party(request)
    if not address.can_have_passkeys:
        raise ApiProblem(
            409, "no_name", "passkeys need a name in the address bar, and not an IP address"
        )
    return address
