"""Roles and their permissions, as data."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import delete, func, insert, select, update

from talaia.hub.auth.passwords import name_key
from talaia.hub.errors import NameTaken, RoleInUse, SeededRole, UnknownRole
from talaia.hub.store.accounts.permission_grants import OF_ROLES, grant_permissions, grants_of
from talaia.hub.store.tables import roles, users

if TYPE_CHECKING:
    from collections.abc import Iterable

    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.hub.auth.permissions import Grants, Permission
    from talaia.hub.store.database import Database

__all__ = ["ADMIN", "Role", "Roles"]

# The seeded role that manages the hub; its permissions cannot be taken from it.
ADMIN = "admin"


class Role(NamedTuple):
    """One role; ``people`` counts those who have it.

    ``factor_required``: they sign in with a second factor, or set one up before anything else.
    """

    id: int
    name: str
    seeded: bool
    people: int
    grants: Grants
    factor_required: bool


class Roles:
    """List, add, change and remove roles."""

    def __init__(self, database: Database) -> None:
        """Work on ``database``."""
        self._database = database

    async def list_roles(self) -> list[Role]:
        """List every role, the seeded ones first."""
        async with self._database.read() as connection:
            rows = (
                await connection.execute(
                    select(
                        roles.c.id,
                        roles.c.name,
                        roles.c.seeded,
                        func.count(users.c.id),
                        roles.c.factor_required,
                    )
                    .join(users, users.c.role_id == roles.c.id, isouter=True)
                    .group_by(roles.c.id, roles.c.name, roles.c.seeded, roles.c.factor_required)
                    .order_by(roles.c.id)
                )
            ).all()
            held = await grants_of(connection, OF_ROLES, [row[0] for row in rows])
        return [
            Role(row[0], row[1], bool(row[2]), row[3], held[row[0]], bool(row[4])) for row in rows
        ]

    async def find_role(self, role: int) -> Role:
        """Find a role.

        Raises:
            UnknownRole: there is none of that number.

        """
        for found in await self.list_roles():
            if found.id == role:
                return found
        raise UnknownRole("there is no such role")

    async def add_role(self, name: str, given: Iterable[Permission]) -> int:
        """Add a role; give its number.

        Raises:
            NameTaken: there is one of that name, in any case.

        """
        async with self._database.write() as connection:
            await _check_name_free(connection, name, 0)
            added = await connection.execute(insert(roles).values(name=name, seeded=False))
            key = added.inserted_primary_key
            role = int(key[0]) if key else 0
            await grant_permissions(connection, OF_ROLES, role, given)
        return role

    async def change_role(self, role: int, name: str, given: Iterable[Permission]) -> None:
        """Give a role another name or other permissions; open sockets follow within a second.

        Raises:
            UnknownRole: there is none of that number.
            NameTaken: there is another of that name.
            SeededRole: it came with the hub and keeps its name, or it is the admin's.

        """
        async with self._database.write() as connection:
            before, seeded = await _read_role(connection, role)
            if seeded and name != before:
                raise SeededRole(f"the role {before!r} came with the hub and keeps its name")
            if seeded and before == ADMIN:
                raise SeededRole("the permissions of admin cannot be changed")
            await _check_name_free(connection, name, role)
            await connection.execute(update(roles).where(roles.c.id == role).values(name=name))
            await grant_permissions(connection, OF_ROLES, role, given)

    async def require_factor(self, role: int, *, required: bool) -> str:
        """Say whether a role requires a second factor; give the role's name.

        Raises:
            UnknownRole: there is none of that number.

        """
        async with self._database.write() as connection:
            name, _ = await _read_role(connection, role)
            await connection.execute(
                update(roles).where(roles.c.id == role).values(factor_required=required)
            )
        return name

    async def remove_role(self, role: int) -> str:
        """Remove a role; give the name it had.

        Raises:
            UnknownRole: there is none of that number.
            SeededRole: it came with the hub.
            RoleInUse: people have it.

        """
        async with self._database.write() as connection:
            name, seeded = await _read_role(connection, role)
            if seeded:
                raise SeededRole(f"the role {name!r} came with the hub and stays")
            people = select(func.count()).select_from(users).where(users.c.role_id == role)
            count = (await connection.execute(people)).scalar_one()
            if count:
                raise RoleInUse(f"{count} people have the role {name!r}", "give them another first")
            await grant_permissions(connection, OF_ROLES, role, ())
            await connection.execute(delete(roles).where(roles.c.id == role))
        return name


async def _read_role(connection: AsyncConnection, role: int) -> tuple[str, bool]:
    found = (
        await connection.execute(select(roles.c.name, roles.c.seeded).where(roles.c.id == role))
    ).first()
    if found is None:
        raise UnknownRole("there is no such role")
    return found.name, bool(found.seeded)


async def _check_name_free(connection: AsyncConnection, name: str, but: int) -> None:
    """Hold a name against those of the other roles, as names of people are compared."""
    others = await connection.execute(select(roles.c.name).where(roles.c.id != but))
    if name_key(name) in {name_key(other) for other in others.scalars()}:
        raise NameTaken(f"there is a role named {name!r} already")
