"""A person proves who they are: name, password and second factor, throttled."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND
from talaia.hub.api.access import address_of
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.server.silent_connections import network_of
from talaia.hub.auth.passwords import name_key
from talaia.hub.store.accounts.mfa import CodeVerdict
from talaia.hub.store.safe_text import safe_text

if TYPE_CHECKING:
    from collections.abc import Callable

    from fastapi import Request

    from talaia.hub.api.accounts.browser_sessions import BrowserSessions
    from talaia.hub.auth.passwords import Passwords
    from talaia.hub.store.accounts.failed_logins import FailedLogins
    from talaia.hub.store.accounts.mfa import SecondFactors
    from talaia.hub.store.accounts.people import People, Person
    from talaia.hub.store.audit import Audit

__all__ = ["Authentication", "SignInAttempt"]

_REFUSED = {
    CodeVerdict.WRONG: "the code is wrong",
    CodeVerdict.REPLAYED: "this code was used already; wait for the next one",
}
# The page offers what still opens.
_LOCKED = {
    CodeVerdict.LOCKED: "codes are locked after many wrong ones; use a recovery code or a passkey",
    CodeVerdict.LOCKS: "the code is wrong, and one too many: codes are locked for an hour",
}


class SignInAttempt(NamedTuple):
    """What tries are counted by."""

    # The name without case, an address or network, and the browser's own secret; see `Throttle`.
    user: str
    address: str
    browser: str


class Authentication:
    """Checks what a person knows and has. What is wrong is counted, and more of it must wait."""

    def __init__(
        self,
        *,
        sessions: BrowserSessions,
        people: People,
        passwords: Passwords,
        factors: SecondFactors,
        tries: FailedLogins,
        audit: Audit,
    ) -> None:
        """Count in ``tries``; ``sessions`` knows a browser from earlier sign-ins."""
        # Knows whether the browser has been here with this person before.
        self._sessions = sessions
        self._people = people
        self._passwords = passwords
        self._factors = factors
        # Every wrong try, kept over restarts: a restart must give nobody new ones.
        self._tries = tries
        self._audit = audit
        # Called when a message to a person was put into the outbox; whoever delivers sets it.
        self.on_notice: Callable[[], None] = lambda: None

    async def sign_in(self, request: Request, name: str, password: str, code: str) -> Person:
        """Check name, password and, where there is one, the second factor.

        Wrong name and wrong password look alike, and take as long.

        Raises:
            ApiProblem: 401 ``wrong``, 401 ``factor``, 429 ``busy``.

        """
        # Counted before anything is looked at: who breaks off half-way has tried, too.
        ask = await self.begin_attempt(request, name)
        person = await self._check_password(
            request, name=name, password=password, status=401, what="login failed"
        )
        if person.factor:
            await self._check_factor(
                request, ask=ask, person=person, code=code, status=401, what="login failed"
            )
        # Only now: a right password with a wrong code is a wrong try.
        await self.clear_attempt(ask)
        return person

    async def confirm_password(
        self, request: Request, user: int, password: str, what: str
    ) -> Person:
        """Check the password of a person who is signed in; ``what`` is in the audit log else.

        Raises:
            ApiProblem: 403 ``wrong``, 429 ``busy``.

        """
        # By number: the name could have been given to somebody else meanwhile.
        person = await self._find_person(user)
        ask = await self.begin_attempt(request, person.name)
        person = await self._check_password(
            request, name=person.name, password=password, status=403, what=what
        )
        await self.clear_attempt(ask)
        return person

    async def confirm_both(
        self, request: Request, *, user: int, password: str, code: str, what: str
    ) -> Person:
        """Check the password and the second factor of a person who is signed in.

        Raises:
            ApiProblem: 403 ``wrong``, 403 ``factor``, 429 ``busy``.

        """
        person = await self._find_person(user)
        ask = await self.begin_attempt(request, person.name)
        person = await self._check_password(
            request, name=person.name, password=password, status=403, what=what
        )
        await self._check_factor(request, ask=ask, person=person, code=code, status=403, what=what)
        await self.clear_attempt(ask)
        return person

    async def check_first_half(self, request: Request, name: str, password: str) -> Person:
        """Check name and password of one whose second factor is not a code.

        Raises:
            ApiProblem: 401 ``wrong``, 429 ``busy``.

        """
        ask = await self.begin_attempt(request, name)
        person = await self._check_password(
            request, name=name, password=password, status=401, what="login failed"
        )
        # The second half is counted for itself.
        await self._tries.count_unfinished(ask.user, ask.address, ask.browser)
        return person

    async def begin_attempt(self, request: Request, name: str) -> SignInAttempt:
        """Count a try as wrong before it is looked at; `clear_attempt` takes it off.

        Raises:
            ApiProblem: 429 ``busy``.

        """
        # Known to this very person: another's cookie must not take the name's count away.
        browser = await self._sessions.known_browser(request, name)
        ask = SignInAttempt(name_key(name), network_of(address_of(request)), browser)
        wait_ns = await self._tries.count_attempt(ask.user, ask.address, ask.browser)
        if wait_ns:
            # In whole seconds, rounded up.
            raise ApiProblem(
                429, "busy", "too many wrong tries; wait a little", -(-wait_ns // SECOND)
            )
        return ask

    async def _find_person(self, user: int) -> Person:
        person = await self._people.find_by_id(user)
        if person is None:
            raise ApiProblem(401, "unauthorized", "sign in first")
        return person

    async def _check_password(
        self, request: Request, *, name: str, password: str, status: int, what: str
    ) -> Person:
        person = await self._people.find_by_name(name)
        # Who is unknown or disabled is checked against a hash of nobody's, for as long.
        # So is who has none, and signs in by the provider.
        kept = (person.password_hash or None) if person and not person.disabled else None
        if await self._passwords.verify_password(password, kept) and person is not None:
            return person
        self._append_record(request, what, name, "")
        said = "name or password is wrong" if status == 401 else "the password is wrong"
        raise ApiProblem(status, "wrong", said)

    async def _check_factor(
        self,
        request: Request,
        *,
        ask: SignInAttempt,
        person: Person,
        code: str,
        status: int,
        what: str,
    ) -> None:
        if not code:
            # The password was right: this is the first half of a sign-in, and no wrong try.
            await self._tries.count_unfinished(ask.user, ask.address, ask.browser)
            raise ApiProblem(status, "factor", "the code of your second factor is needed")
        verdict = await self._factors.use_code(person.id, code)
        if verdict in _LOCKED:
            self._append_record(request, what, person.name, "second factor locked")
            if verdict is CodeVerdict.LOCKS:
                self._append_record(request, "second factor locked", person.name, "")
                # The message about it is in the outbox.
                self.on_notice()
            raise ApiProblem(status, "factor_locked", _LOCKED[verdict])
        if verdict in _REFUSED:
            self._append_record(request, what, person.name, "second factor")
            raise ApiProblem(status, "factor", _REFUSED[verdict])
        if verdict is CodeVerdict.RECOVERY:
            self._append_record(request, "recovery code used", person.name, "", good=True)

    async def clear_attempt(self, ask: SignInAttempt) -> None:
        """Forget the wrong tries of one who has proved who they are."""
        await self._tries.count_success(ask.user, ask.address, ask.browser)

    def _append_record(
        self, request: Request, what: str, name: str, message: str, *, good: bool = False
    ) -> None:
        self._audit.append_record(
            what, who=safe_text(name, 200), address=address_of(request), message=message, good=good
        )
