"""API tokens: what a script signs in with, with some of a person's rights, until an end date."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import delete, func, insert, select, update

from talaia.hub.auth.permissions import Who
from talaia.hub.auth.tokens import TOKEN_MARK, hash_token, new_token
from talaia.hub.store.accounts.permission_grants import (
    OF_ROLES,
    OF_TOKENS,
    grant_permissions,
    grants_of,
)
from talaia.hub.store.accounts.sessions import LiveSession
from talaia.hub.store.tables import api_tokens, roles, users

if TYPE_CHECKING:
    from collections.abc import Collection

    from talaia.clock import Clock
    from talaia.hub.auth.permissions import Grants, Permission
    from talaia.hub.store.database import Database

__all__ = ["MARK", "MOST", "ApiToken", "ApiTokens"]

MARK = TOKEN_MARK
# What names a token among the names of sessions.
_NAMED = "token:"
# A use is written down at most so often (µs).
_TOUCH_US = 60_000_000
# Of one person.
MOST = 100


class ApiToken(NamedTuple):
    """A token as its person sees it in the list; ``used_us`` is 0 until its first use."""

    id: int
    name: str
    created_us: int
    ends_us: int
    used_us: int
    grants: Grants


class ApiTokens:
    """Tokens in the database, kept as their hashes only."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` tells which have ended."""
        self._database = database
        self._clock = clock

    async def tokens_of(self, user: int) -> list[ApiToken]:
        """List a person's tokens that have not ended, the newest first."""
        async with self._database.read() as connection:
            rows = (
                await connection.execute(
                    select(
                        api_tokens.c.id,
                        api_tokens.c.name,
                        api_tokens.c.created_us,
                        api_tokens.c.ends_us,
                        api_tokens.c.used_us,
                    )
                    .where(api_tokens.c.user_id == user, api_tokens.c.ends_us > self._now_us())
                    .order_by(api_tokens.c.id.desc())
                )
            ).all()
            held = await grants_of(connection, OF_TOKENS, [row.id for row in rows])
        return [ApiToken(*row, held[row.id]) for row in rows]

    async def add_token(
        self, user: int, name: str, ends_us: int, given: Collection[Permission]
    ) -> tuple[int, str] | None:
        """Make a token; give its number and its text, which is never shown again.

        Returns:
            None when the person has as many as may be.

        """
        text, now = MARK + new_token(), self._now_us()
        async with self._database.write() as connection:
            await connection.execute(delete(api_tokens).where(api_tokens.c.ends_us <= now))
            count = select(func.count()).select_from(api_tokens).where(api_tokens.c.user_id == user)
            if (await connection.execute(count)).scalar_one() >= MOST:
                return None
            added = await connection.execute(
                insert(api_tokens).values(
                    user_id=user,
                    name=name,
                    token_hash=hash_token(text),
                    created_us=now,
                    ends_us=ends_us,
                    used_us=0,
                )
            )
            key = added.inserted_primary_key
            token = int(key[0]) if key else 0
            await grant_permissions(connection, OF_TOKENS, token, given)
        return token, text

    async def revoke_token(self, user: int, token: int) -> str | None:
        """Revoke a person's token; give the name it had, None when they have none such."""
        async with self._database.write() as connection:
            # With the person's number too: nobody removes another's token.
            mine = (api_tokens.c.id == token, api_tokens.c.user_id == user)
            name = (await connection.execute(select(api_tokens.c.name).where(*mine))).scalar()
            if name is not None:
                await grant_permissions(connection, OF_TOKENS, token, ())
                await connection.execute(delete(api_tokens).where(*mine))
        return name

    async def find_session(self, text: str) -> LiveSession | None:
        """Tell for whom a token speaks; None when it is unknown, revoked or has ended."""
        key = _NAMED + hash_token(text)
        found = (await self.live_sessions([key])).get(key)
        if found is not None and found.used_us < self._now_us() - _TOUCH_US:
            await self._mark_token(key)
        return found

    async def live_sessions(self, keys: Collection[str]) -> dict[str, LiveSession]:
        """Give those of the tokens that are good, with what is left of their rights now.

        A token never has more than its person has at this moment.
        """
        hashes = [key.removeprefix(_NAMED) for key in keys if key.startswith(_NAMED)]
        if not hashes:
            return {}
        async with self._database.read() as connection:
            rows = (
                await connection.execute(
                    select(
                        api_tokens.c.token_hash,
                        api_tokens.c.id,
                        api_tokens.c.ends_us,
                        api_tokens.c.used_us,
                        users.c.id.label("user"),
                        users.c.name,
                        users.c.role_id,
                        roles.c.name.label("role"),
                    )
                    .join(users, users.c.id == api_tokens.c.user_id)
                    .join(roles, roles.c.id == users.c.role_id)
                    .where(
                        api_tokens.c.token_hash.in_(hashes),
                        ~users.c.disabled,
                        api_tokens.c.ends_us > self._now_us(),
                    )
                )
            ).all()
            theirs = await grants_of(connection, OF_ROLES, {row.role_id for row in rows})
            asked = await grants_of(connection, OF_TOKENS, {row.id for row in rows})
        return {
            _NAMED + row.token_hash: LiveSession(
                Who(
                    _NAMED + row.token_hash,
                    row.user,
                    row.name,
                    row.role,
                    theirs[row.role_id].limited_to(asked[row.id].permissions),
                    script=True,
                ),
                # Use does not prolong a token, so it has one end.
                row.ends_us,
                row.ends_us,
                row.used_us,
            )
            for row in rows
        }

    async def _mark_token(self, key: str) -> None:
        async with self._database.write() as connection:
            await connection.execute(
                update(api_tokens)
                .where(api_tokens.c.token_hash == key.removeprefix(_NAMED))
                .values(used_us=self._now_us())
            )

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000
