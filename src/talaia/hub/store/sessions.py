"""Sessions: from a sign-in to its end, by log-out, by time or because rights changed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import and_, delete, insert, select, update

from talaia.hub.auth.permissions import Grants, Permission, Right, Who
from talaia.hub.auth.tokens import hash_token, new_token
from talaia.hub.store.tables import permissions, role_permissions, roles, sessions, users

if TYPE_CHECKING:
    from collections.abc import Collection

    from sqlalchemy import ColumnElement
    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.clock import Clock
    from talaia.hub.settings import Settings
    from talaia.hub.store.database import Database

__all__ = ["Sessions"]

# A use is written down at most this often, so that reading costs no writing.
_TOUCH_US = 60_000_000


class Sessions:
    """Sessions in the database; a token is kept as its hash only."""

    def __init__(self, database: Database, clock: Clock, settings: Settings) -> None:
        """Take the time-outs from ``settings``."""
        self._database = database
        self._clock = clock
        self._idle_us = round(settings.idle_s * 1e6)
        self._life_us = round(settings.life_s * 1e6)

    async def begin(self, user: int, address: str) -> tuple[str, Who]:
        """Start a session; give the token for the cookie and whom it stands for."""
        token = new_token()
        now = self._now_us()
        async with self._database.write() as connection:
            await connection.execute(delete(sessions).where(~self._alive(now)))
            await connection.execute(
                insert(sessions).values(
                    token_hash=hash_token(token),
                    user_id=user,
                    created_us=now,
                    used_us=now,
                    address=address[:200],
                )
            )
            found = await self._read(connection, [hash_token(token)])
        return token, found[hash_token(token)]

    async def who(self, token: str) -> Who | None:
        """Tell who holds ``token``; None when it stands for no living session."""
        hashed = hash_token(token)
        return (await self.living([hashed])).get(hashed)

    async def living(self, hashes: Collection[str]) -> dict[str, Who]:
        """Give those of the sessions that are alive, with their people's rights of now."""
        if not hashes:
            return {}
        async with self._database.read() as connection:
            found = await self._read(connection, hashes)
            untouched = await self._untouched(connection, found)
        if untouched:
            await self._touch(untouched)
        return found

    async def end(self, hashed: str) -> None:
        """End one session."""
        async with self._database.write() as connection:
            await connection.execute(delete(sessions).where(sessions.c.token_hash == hashed))

    async def end_all(self, user: int) -> None:
        """End every session of a person."""
        async with self._database.write() as connection:
            await connection.execute(delete(sessions).where(sessions.c.user_id == user))

    async def _read(self, connection: AsyncConnection, hashes: Collection[str]) -> dict[str, Who]:
        rows = await connection.execute(
            select(
                sessions.c.token_hash,
                users.c.id,
                users.c.name,
                users.c.role_id,
                roles.c.name.label("role"),
            )
            .join(users, users.c.id == sessions.c.user_id)
            .join(roles, roles.c.id == users.c.role_id)
            .where(
                sessions.c.token_hash.in_(hashes),
                ~users.c.disabled,
                self._alive(self._now_us()),
            )
        )
        people = rows.all()
        held = await _grants(connection, {row.role_id for row in people})
        return {
            row.token_hash: Who(row.token_hash, row.id, row.name, row.role, held[row.role_id])
            for row in people
        }

    async def _untouched(self, connection: AsyncConnection, found: dict[str, Who]) -> list[str]:
        rows = await connection.execute(
            select(sessions.c.token_hash).where(
                sessions.c.token_hash.in_(found), sessions.c.used_us < self._now_us() - _TOUCH_US
            )
        )
        return list(rows.scalars())

    async def _touch(self, hashes: list[str]) -> None:
        async with self._database.write() as connection:
            await connection.execute(
                update(sessions)
                .where(sessions.c.token_hash.in_(hashes))
                .values(used_us=self._now_us())
            )

    def _alive(self, now_us: int) -> ColumnElement[bool]:
        return and_(
            sessions.c.used_us > now_us - self._idle_us,
            sessions.c.created_us > now_us - self._life_us,
        )

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000


async def _grants(connection: AsyncConnection, role_ids: Collection[int]) -> dict[int, Grants]:
    """Read the permissions of each role."""
    rows = await connection.execute(
        select(
            role_permissions.c.role_id,
            permissions.c.right_name,
            permissions.c.site,
            permissions.c.device,
        )
        .join(permissions, permissions.c.id == role_permissions.c.permission_id)
        .where(role_permissions.c.role_id.in_(role_ids))
    )
    held: dict[int, set[Permission]] = {role: set() for role in role_ids}
    for row in rows:
        held[row.role_id].add(Permission(Right(row.right_name), row.site, row.device))
    return {role: Grants(frozenset(each)) for role, each in held.items()}
