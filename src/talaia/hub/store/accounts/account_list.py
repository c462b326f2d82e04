"""All people, as those who manage the hub see and change them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import delete, func, select, update

from talaia.hub.errors import LastAdmin, UnknownPerson
from talaia.hub.store.accounts.passkeys import has_factor
from talaia.hub.store.accounts.people import role_number, set_hash, sign_out
from talaia.hub.store.accounts.roles import ADMIN
from talaia.hub.store.tables import api_tokens, identities, roles, sessions, users

if TYPE_CHECKING:
    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.hub.store.accounts.sessions import Sessions
    from talaia.hub.store.database import Database

__all__ = ["AccountEntry", "AccountList"]


class AccountEntry(NamedTuple):
    """One person; ``sessions`` counts those that are alive. Times in µs (UTC), 0: never.

    ``provider``: the provider of sign-ins signs them in.
    """

    id: int
    name: str
    role: str
    disabled: bool
    factor: bool
    created_us: int
    used_us: int
    sessions: int
    provider: bool = False


class AccountList:
    """Lists people and changes what they are. The last admin who can sign in always stays one."""

    def __init__(self, database: Database, alive: Sessions) -> None:
        """Ask ``alive`` which sessions count."""
        self._database = database
        self._alive = alive

    async def list_accounts(self) -> list[AccountEntry]:
        """List everyone by name."""
        async with self._database.read() as connection:
            return await self._read_entries(connection)

    async def find_account(self, user: int) -> AccountEntry:
        """Find a person.

        Raises:
            UnknownPerson: there is nobody of that number.

        """
        async with self._database.read() as connection:
            return await self._read_account(connection, user)

    async def change_account(
        self,
        user: int,
        *,
        role: str | None = None,
        disabled: bool | None = None,
        password_hash: str | None = None,
    ) -> AccountEntry:
        """Change what is given; every session of the person ends with any change of theirs.

        Raises:
            UnknownPerson: there is nobody of that number.
            UnknownRole: there is no such role.
            LastAdmin: nobody would be left to manage the hub.

        """
        async with self._database.write() as connection:
            before = await self._read_account(connection, user)
            values: dict[str, object] = {}
            if role is not None and role != before.role:
                values["role_id"] = await role_number(connection, role)
            if disabled is not None and disabled != before.disabled:
                values["disabled"] = disabled
            if password_hash is not None:
                await set_hash(connection, user, password_hash)
            if values:
                await connection.execute(update(users).where(users.c.id == user).values(values))
                await sign_out(connection, user)
            await _someone_manages(connection)
            return await self._read_account(connection, user)

    async def remove_account(self, user: int) -> AccountEntry:
        """Remove a person with sessions and tokens; give what was known of them.

        Raises:
            UnknownPerson: there is nobody of that number.
            LastAdmin: nobody would be left to manage the hub.

        """
        async with self._database.write() as connection:
            gone = await self._read_account(connection, user)
            await sign_out(connection, user)
            await connection.execute(delete(api_tokens).where(api_tokens.c.user_id == user))
            await connection.execute(delete(users).where(users.c.id == user))
            await _someone_manages(connection)
        return gone

    async def _read_account(self, connection: AsyncConnection, user: int) -> AccountEntry:
        found = await self._read_entries(connection, user)
        if not found:
            raise UnknownPerson("there is no such person")
        return found[0]

    async def _read_entries(
        self, connection: AsyncConnection, user: int | None = None
    ) -> list[AccountEntry]:
        open_now = (
            select(sessions.c.user_id, func.count().label("open"))
            .where(self._alive.alive_now())
            .group_by(sessions.c.user_id)
            .subquery()
        )
        asked = (
            select(
                users.c.id,
                users.c.name,
                roles.c.name.label("role"),
                users.c.disabled,
                has_factor().label("factor"),
                users.c.created_us,
                users.c.used_us,
                func.coalesce(open_now.c.open, 0).label("open"),
                users.c.id.in_(select(identities.c.user_id)).label("provider"),
            )
            .join(roles, roles.c.id == users.c.role_id)
            .join(open_now, open_now.c.user_id == users.c.id, isouter=True)
            .order_by(users.c.name_key)
        )
        rows = await connection.execute(asked if user is None else asked.where(users.c.id == user))
        return [
            AccountEntry(
                row.id,
                row.name,
                row.role,
                bool(row.disabled),
                bool(row.factor),
                row.created_us,
                row.used_us,
                row.open,
                bool(row.provider),
            )
            for row in rows
        ]


async def _someone_manages(connection: AsyncConnection) -> None:
    """Refuse what was done in this transaction when no admin is left who can sign in."""
    able = (
        select(func.count())
        .select_from(users)
        .join(roles, roles.c.id == users.c.role_id)
        .where(roles.c.name == ADMIN, ~users.c.disabled)
    )
    if not (await connection.execute(able)).scalar_one():
        raise LastAdmin(
            "the last admin cannot be removed, disabled or made less", "make another admin first"
        )
