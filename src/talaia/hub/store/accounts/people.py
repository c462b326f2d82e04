"""People and their roles, as the database holds them: found, added, and the first one set up."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import delete, func, insert, select, update
from sqlalchemy.exc import IntegrityError

from talaia.hub.auth.passwords import name_key
from talaia.hub.auth.tokens import hash_token, new_token
from talaia.hub.errors import NameTaken, UnknownPerson, UnknownRole
from talaia.hub.store.accounts.passkeys import has_factor
from talaia.hub.store.accounts.roles import ADMIN
from talaia.hub.store.tables import (
    api_tokens,
    known_browsers,
    roles,
    sessions,
    setup_tokens,
    token_permissions,
    users,
)

if TYPE_CHECKING:
    from sqlalchemy import Row, Select
    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.clock import Clock
    from talaia.hub.store.database import Database

__all__ = ["People", "Person", "role_number", "set_hash", "sign_out"]


class Person(NamedTuple):
    """What a sign-in needs to know of a person."""

    id: int
    name: str
    role: str
    password_hash: str
    disabled: bool
    factor: bool


class People:
    """Find, add and set up people."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` stamps what is added."""
        self._database = database
        self._clock = clock

    async def find_by_name(self, name: str) -> Person | None:
        """Find a person by name, in any case."""
        key = name_key(name)
        # PostgreSQL refuses such a text, and nobody has that name.
        if "\0" in key:
            return None
        async with self._database.read() as connection:
            found = (
                await connection.execute(_select_people().where(users.c.name_key == key))
            ).first()
        # MariaDB takes a name with spaces at its end for the same; the throttle does not.
        return _row_to_person(found) if found is not None and found.name_key == key else None

    async def find_by_id(self, user: int) -> Person | None:
        """Find a person by number."""
        async with self._database.read() as connection:
            found = (await connection.execute(_select_people().where(users.c.id == user))).first()
        return None if found is None else _row_to_person(found)

    async def add_person(self, name: str, password_hash: str, role: str) -> int:
        """Add a person; give the number.

        Raises:
            NameTaken: there is one of that name.
            UnknownRole: there is no such role.

        """
        async with self._database.write() as connection:
            return await self._insert_person(connection, name, password_hash, role)

    async def set_password(self, name: str, password_hash: str) -> None:
        """Give a person another password; every session of theirs ends.

        Raises:
            UnknownPerson: there is nobody of that name.

        """
        async with self._database.write() as connection:
            await set_hash(connection, await _person_id(connection, name), password_hash)

    async def change_password(self, user: int, password_hash: str, keep: str) -> None:
        """Give a person another password; every session of theirs but ``keep`` ends."""
        async with self._database.write() as connection:
            await set_hash(connection, user, password_hash, keep)

    async def set_role(self, name: str, role: str) -> None:
        """Give a person another role. Open sockets follow within a second.

        Raises:
            UnknownRole: there is no such role.

        """
        async with self._database.write() as connection:
            await connection.execute(
                update(users)
                .where(users.c.name_key == name_key(name))
                .values(role_id=await role_number(connection, role))
            )

    async def offer_setup(self, life_s: float) -> str | None:
        """Make a one-time token for the first admin; None when there are people already."""
        token = new_token()
        async with self._database.write() as connection:
            if await _count_people(connection):
                return None
            await connection.execute(delete(setup_tokens))
            await connection.execute(
                insert(setup_tokens).values(
                    token_hash=hash_token(token), expires_us=self._now_us() + round(life_s * 1e6)
                )
            )
        return token

    async def may_set_up(self, token: str) -> bool:
        """Tell whether a set-up token is good, without using it."""
        async with self._database.read() as connection:
            return await self._is_good_token(connection, token)

    async def set_up(self, token: str, name: str, password_hash: str) -> int | None:
        """Use the token to add the first admin; of two at once exactly one wins.

        Returns:
            The person's number, or None when the token is not good (any more).

        """
        async with self._database.write() as connection:
            # Asked in the transaction that adds: two who set up at once do not both become admin.
            if not await self._is_good_token(connection, token) or await _count_people(connection):
                return None
            await connection.execute(delete(setup_tokens))
            return await self._insert_person(connection, name, password_hash, ADMIN)

    async def _is_good_token(self, connection: AsyncConnection, token: str) -> bool:
        rows = await connection.execute(
            select(setup_tokens.c.expires_us).where(
                setup_tokens.c.token_hash == hash_token(token),
                setup_tokens.c.expires_us > self._now_us(),
            )
        )
        return rows.first() is not None

    async def _insert_person(
        self, connection: AsyncConnection, name: str, password_hash: str, role: str
    ) -> int:
        try:
            result = await connection.execute(
                insert(users).values(
                    name=name,
                    name_key=name_key(name),
                    password_hash=password_hash,
                    role_id=await role_number(connection, role),
                    disabled=False,
                    created_us=self._now_us(),
                    factor_secret="",
                    factor_pending="",
                    factor_step=0,
                    used_us=0,
                    code_wrong=0,
                    code_locked_us=0,
                    code_alert_us=0,
                )
            )
        # The unique key decides: of two that add one name at once one gets this.
        except IntegrityError as error:
            raise NameTaken(f"there is a person named {name!r} already") from error
        key = result.inserted_primary_key
        return int(key[0]) if key else 0

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000


async def role_number(connection: AsyncConnection, role: str) -> int:
    """Give the number of a role.

    Raises:
        UnknownRole: there is no such role.

    """
    found = (await connection.execute(select(roles.c.id, roles.c.name))).all()
    for number, name in found:
        if name == role:
            return int(number)
    known = ", ".join(sorted(name for _, name in found))
    raise UnknownRole(f"there is no role {role!r}", f"use one of: {known}")


async def sign_out(connection: AsyncConnection, user: int, keep: str = "") -> None:
    """End every session of a person but ``keep``."""
    await connection.execute(
        delete(sessions).where(sessions.c.user_id == user, sessions.c.token_hash != keep)
    )


async def set_hash(
    connection: AsyncConnection, user: int, password_hash: str, keep: str = ""
) -> None:
    """Give a person another password: sessions but ``keep`` and all tokens of scripts end.

    No browser is known any more either.
    """
    # Whoever signed in with the old password is signed out, but for the session that is kept.
    await sign_out(connection, user, keep)
    # Who knew the old password may have made tokens with it, which would outlive the change.
    mine = select(api_tokens.c.id).where(api_tokens.c.user_id == user)
    await connection.execute(
        delete(token_permissions).where(token_permissions.c.token_id.in_(mine))
    )
    await connection.execute(delete(api_tokens).where(api_tokens.c.user_id == user))
    await connection.execute(delete(known_browsers).where(known_browsers.c.user_id == user))
    await connection.execute(
        update(users)
        .where(users.c.id == user)
        # Who tried codes knew the old password; with it they do not get so far any more.
        .values(password_hash=password_hash, code_wrong=0, code_locked_us=0)
    )


async def _count_people(connection: AsyncConnection) -> int:
    return (await connection.execute(select(func.count()).select_from(users))).scalar_one()


async def _person_id(connection: AsyncConnection, name: str) -> int:
    found = select(users.c.id).where(users.c.name_key == name_key(name))
    user = (await connection.execute(found)).scalar()
    if user is None:
        raise UnknownPerson(f"there is no person named {name!r}")
    return int(user)


def _select_people() -> Select[tuple[int, str, str, str, bool, bool, str]]:
    return select(
        users.c.id,
        users.c.name,
        roles.c.name.label("role"),
        users.c.password_hash,
        users.c.disabled,
        has_factor().label("factor"),
        users.c.name_key,
    ).join(roles, roles.c.id == users.c.role_id)


def _row_to_person(row: Row[tuple[int, str, str, str, bool, bool, str]]) -> Person:
    return Person(
        row.id, row.name, row.role, row.password_hash, bool(row.disabled), bool(row.factor)
    )
