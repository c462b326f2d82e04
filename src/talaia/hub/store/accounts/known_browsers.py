"""Browsers from which a person has signed in before, each known by a cookie of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import delete, insert, select, update

from talaia.hub.auth.passwords import name_key
from talaia.hub.auth.tokens import hash_token, new_token
from talaia.hub.store.tables import known_browsers, users

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.store.database import Database

__all__ = ["KNOWN_S", "KnownBrowsers"]

# A browser that was not signed in from for this long is not known any more (s).
KNOWN_S = 180 * 86400
# Of one person; those that were used longest ago go.
_MOST = 20


class KnownBrowsers:
    """Knows browsers by person; a cookie of one is worth nothing for another."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` tells how long ago a browser was seen."""
        self._database = database
        self._clock = clock

    async def is_known(self, token: str, name: str) -> bool:
        """Tell whether the person of this name has signed in from that browser before."""
        async with self._database.read() as connection:
            found = await connection.execute(
                select(users.c.name_key)
                .join(known_browsers, known_browsers.c.user_id == users.c.id)
                .where(
                    known_browsers.c.token_hash == hash_token(token),
                    known_browsers.c.used_us > self._now_us() - KNOWN_S * 1_000_000,
                )
            )
            # Known for whoever has signed in there, for nobody else.
            return found.scalar() == name_key(name)

    async def remember_browser(self, user: int, token: str) -> str:
        """Know a browser from now on; give the token for its cookie, ``token`` if it is known."""
        now = self._now_us()
        mine = known_browsers.c.user_id == user
        async with self._database.write() as connection:
            again = await connection.execute(
                update(known_browsers)
                .where(mine, known_browsers.c.token_hash == hash_token(token))
                .values(used_us=now)
            )
            if again.rowcount:
                return token
            last_used = await connection.execute(
                select(known_browsers.c.token_hash)
                .where(mine)
                .order_by(known_browsers.c.used_us.desc())
            )
            too_many = list(last_used.scalars())[_MOST - 1 :]
            if too_many:
                await connection.execute(
                    delete(known_browsers).where(known_browsers.c.token_hash.in_(too_many))
                )
            fresh = new_token()
            await connection.execute(
                insert(known_browsers).values(
                    token_hash=hash_token(fresh), user_id=user, created_us=now, used_us=now
                )
            )
        return fresh

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000
