"""People, as an admin adds, changes and removes them."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

from fastapi import APIRouter, Request

from talaia.hub.api.access import address_of, number_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.account_schemas import PersonAsk, PersonChange, PersonList, PersonShape
from talaia.hub.auth.passwords import check_name, check_password
from talaia.hub.errors import LastAdmin, NameTaken, UnknownPerson, UnknownRole, WeakPassword

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.hub.api.accounts.browser_sessions import BrowserSessions
    from talaia.hub.auth.passwords import Passwords
    from talaia.hub.store.accounts.account_list import AccountEntry, AccountList
    from talaia.hub.store.accounts.mfa import SecondFactors
    from talaia.hub.store.accounts.people import People
    from talaia.hub.store.audit import Audit

__all__ = ["PeoplePages"]


class PeoplePages:
    """The routes of people."""

    def __init__(
        self,
        *,
        people: People,
        roster: AccountList,
        passwords: Passwords,
        factors: SecondFactors,
        sessions: BrowserSessions,
        audit: Audit,
    ) -> None:
        """Work on ``people`` and ``roster``; open sockets follow each change at once."""
        # The one adds and names people; the other lists and changes them with their sessions.
        self._people = people
        self._roster = roster
        self._passwords = passwords
        self._factors = factors
        self._sessions = sessions
        self._audit = audit

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/people")(self.overview)
        router.post("/api/people")(self.add)
        router.patch("/api/people/{person}")(self.change)
        router.delete("/api/people/{person}", status_code=204)(self.remove)
        router.delete("/api/people/{person}/sessions", status_code=204)(self.end_sessions)
        router.delete("/api/people/{person}/factor", status_code=204)(self.remove_factor)
        return router

    async def overview(self) -> PersonList:
        """List everyone."""
        return PersonList(
            people=[_person_schema(account) for account in await self._roster.list_accounts()]
        )

    async def add(self, asked: PersonAsk, request: Request) -> PersonShape:
        """Add a person."""
        # The rules before the hash, which takes a core for a while.
        with _translate_refusals():
            check_name(asked.name)
            check_password(asked.password, asked.name)
            hashed = await self._passwords.hash_password(asked.password)
            user = await self._people.add_person(asked.name, hashed, asked.role)
            made = await self._roster.find_account(user)
        self._append_record(request, "person added", f"{made.name} ({made.role})")
        return _person_schema(made)

    async def change(self, person: str, asked: PersonChange, request: Request) -> PersonShape:
        """Change a person's role, password, or whether they may sign in; their sessions end.

        With another password their tokens end, too.
        """
        number = number_of(person, "person")
        with _translate_refusals():
            # For the log, which names what has changed.
            before = await self._roster.find_account(number)
            hashed = None
            if asked.password is not None:
                check_password(asked.password, before.name)
                hashed = await self._passwords.hash_password(asked.password)
            after = await self._roster.change_account(
                number, role=asked.role, disabled=asked.disabled, password_hash=hashed
            )
        # At once, instead of at the next check of all sockets.
        await self._sessions.follow_rights()
        said = _describe_changes(before, after, new_password=hashed is not None)
        if said:
            self._append_record(request, "person changed", f"{before.name}: {said}")
        return _person_schema(after)

    async def remove(self, person: str, request: Request) -> None:
        """Remove a person with their sessions and tokens; open sockets are closed at once."""
        with _translate_refusals():
            gone = await self._roster.remove_account(number_of(person, "person"))
        await self._sessions.follow_rights()
        self._append_record(request, "person removed", f"{gone.name} ({gone.role})")

    async def end_sessions(self, person: str, request: Request) -> None:
        """End all of a person's sessions; open sockets are closed at once."""
        with _translate_refusals():
            found = await self._roster.find_account(number_of(person, "person"))
        # They were opened with a factor that somebody else may have now.
        await self._sessions.end_all(found.id)
        self._append_record(request, "person signed out", found.name)

    async def remove_factor(self, person: str, request: Request) -> None:
        """Take a person's second factor away, for one who has lost it; their sessions end."""
        with _translate_refusals():
            found = await self._roster.find_account(number_of(person, "person"))
        if not await self._factors.remove_factor(found.id):
            raise ApiProblem(409, "missing", "this person has no second factor")
        await self._sessions.end_all(found.id)
        self._append_record(request, "person's second factor removed", found.name)

    def _append_record(self, request: Request, kind: str, message: str) -> None:
        who = who_of(request).name
        self._audit.append_record(kind, who=who, address=address_of(request), message=message)


@contextmanager
def _translate_refusals() -> Iterator[None]:
    """Answer what the store and the rules refuse."""
    try:
        yield
    except (WeakPassword, UnknownRole) as error:
        # A role that is not there is a fault of what was sent; a person that is not, of the path.
        raise ApiProblem(422, "invalid", str(error)) from error
    except UnknownPerson as error:
        raise ApiProblem(404, "unknown", str(error)) from error
    except NameTaken as error:
        raise ApiProblem(409, "taken", str(error)) from error
    except LastAdmin as error:
        raise ApiProblem(409, "last_admin", str(error)) from error


def _describe_changes(before: AccountEntry, after: AccountEntry, *, new_password: bool) -> str:
    said = []
    if before.role != after.role:
        said.append(f"role {before.role} -> {after.role}")
    if before.disabled != after.disabled:
        said.append("disabled" if after.disabled else "enabled")
    if new_password:
        said.append("new password")
    return ", ".join(said)


def _person_schema(entry: AccountEntry) -> PersonShape:
    return PersonShape(**{**entry._asdict(), "id": str(entry.id)})
