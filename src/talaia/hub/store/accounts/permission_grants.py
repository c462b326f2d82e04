"""Permissions in the database: each once, and the relations that hand them to roles and tokens."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import and_, bindparam, delete, insert, select

from talaia.hub.auth.permissions import Grants, Permission, Right
from talaia.hub.store.tables import permissions, role_permissions, token_permissions

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable

    from sqlalchemy import Column, Table
    from sqlalchemy.ext.asyncio import AsyncConnection

__all__ = ["OF_ROLES", "OF_TOKENS", "Relation", "grant_permissions", "grants_of"]


class Relation:
    """Who holds permissions, by a table of pairs."""

    def __init__(self, table: Table, holder: str) -> None:
        """Name the table and its column of holders."""
        self.table = table
        self.holder: Column[int] = table.c[holder]
        self.permission: Column[int] = table.c.permission_id
        # Asked with each request: written once.
        self.grants = (
            select(
                self.holder.label("holder"),
                permissions.c.right_name,
                permissions.c.site,
                permissions.c.device,
            )
            .join(permissions, permissions.c.id == self.permission)
            .where(self.holder.in_(bindparam("holders", expanding=True)))
        )


OF_ROLES = Relation(role_permissions, "role_id")
OF_TOKENS = Relation(token_permissions, "token_id")


async def grants_of(
    connection: AsyncConnection, relation: Relation, holders: Collection[int]
) -> dict[int, Grants]:
    """Read the permissions of each holder."""
    rows = await connection.execute(relation.grants, {"holders": list(holders)})
    held: dict[int, set[Permission]] = {holder: set() for holder in holders}
    for row in rows:
        held[row.holder].add(Permission(Right(row.right_name), row.site, row.device))
    return {holder: Grants(frozenset(permissions)) for holder, permissions in held.items()}


async def grant_permissions(
    connection: AsyncConnection, relation: Relation, holder: int, given: Iterable[Permission]
) -> None:
    """Let a holder have exactly these permissions."""
    await connection.execute(delete(relation.table).where(relation.holder == holder))
    numbers = [await _permission_id(connection, permission) for permission in set(given)]
    if numbers:
        await connection.execute(
            insert(relation.table),
            [{relation.holder.name: holder, "permission_id": number} for number in numbers],
        )


async def _permission_id(connection: AsyncConnection, wanted: Permission) -> int:
    """Find a permission, or add it."""
    found = await connection.execute(
        select(permissions.c.id).where(
            and_(
                permissions.c.right_name == wanted.right.value,
                permissions.c.site == wanted.site,
                permissions.c.device == wanted.device,
            )
        )
    )
    number = found.scalar()
    if number is not None:
        return int(number)
    added = await connection.execute(
        insert(permissions).values(
            right_name=wanted.right.value, site=wanted.site, device=wanted.device
        )
    )
    key = added.inserted_primary_key
    return int(key[0]) if key else 0
