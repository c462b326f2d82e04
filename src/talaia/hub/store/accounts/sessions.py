"""Sessions: from a sign-in to its end, by log-out, by time or because rights changed."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import and_, bindparam, delete, insert, select, update

from talaia.clock import SECOND
from talaia.hub.auth.fresh_confirmations import FreshConfirmations
from talaia.hub.auth.permissions import Who
from talaia.hub.auth.tokens import hash_token, new_token
from talaia.hub.store.accounts.passkeys import has_factor
from talaia.hub.store.accounts.permission_grants import OF_ROLES, grants_of
from talaia.hub.store.tables import roles, sessions, users

if TYPE_CHECKING:
    from collections.abc import Collection

    from sqlalchemy import ColumnElement
    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.clock import Clock
    from talaia.hub.settings import Settings
    from talaia.hub.store.database import Database

__all__ = ["LiveSession", "OpenSession", "Sessions"]

# A use is written down at most this often, so that reading costs no writing.
_TOUCH_US = 60_000_000
# Each request asks it, and each time anew: a right that was taken back is gone with the next one.
# Written once, since to put it together takes longer than the database does.
_LIVE_SESSIONS = (
    select(
        sessions.c.token_hash,
        sessions.c.created_us,
        sessions.c.used_us,
        users.c.id,
        users.c.name,
        has_factor().label("factor"),
        users.c.code_alert_us,
        users.c.password_hash,
        sessions.c.provider,
        users.c.role_id,
        roles.c.name.label("role"),
        roles.c.factor_required,
    )
    .join(users, users.c.id == sessions.c.user_id)
    .join(roles, roles.c.id == users.c.role_id)
    .where(
        sessions.c.token_hash.in_(bindparam("hashes", expanding=True)),
        ~users.c.disabled,
        sessions.c.used_us > bindparam("used_after"),
        sessions.c.created_us > bindparam("begun_after"),
    )
)


class LiveSession(NamedTuple):
    """Someone who is signed in, and when that ends: unused, and however much it is used.

    ``codes_locked_us``: when somebody gave too many wrong codes, until the person has seen it.
    ``has_password``: they can sign in by name and password.
    """

    who: Who
    idle_ends_us: int
    ends_us: int
    used_us: int
    codes_locked_us: int = 0
    has_password: bool = True


class OpenSession(NamedTuple):
    """A session as its person sees it in the list."""

    id: str
    created_us: int
    used_us: int
    address: str
    agent: str


class Sessions:
    """Sessions in the database; a token is kept as its hash only."""

    def __init__(self, database: Database, clock: Clock, settings: Settings) -> None:
        """Take the time-outs from ``settings``."""
        self._database = database
        self._clock = clock
        # A session that nobody used for so long is over.
        self._idle_us = round(settings.idle_s * 1e6)
        # So long after it began, it is over however much it is used.
        self._life_us = round(settings.life_s * 1e6)
        self._confirmations = FreshConfirmations(round(settings.confirm_s * SECOND))

    async def start_session(
        self, user: int, address: str, agent: str = "", *, provider: bool = False
    ) -> tuple[str, LiveSession]:
        """Start a session; give the token for the cookie and whom it stands for.

        ``provider``: the person was signed in by the provider, which sees to second factors. That
        may have been long ago there, so it confirms nothing by itself.
        """
        token = new_token()
        hashed = hash_token(token)
        now = self._now_us()
        async with self._database.write() as connection:
            # There is no task that deletes those that are over: it is done when somebody signs in.
            await connection.execute(delete(sessions).where(~self.alive_now()))
            await connection.execute(
                insert(sessions).values(
                    token_hash=hashed,
                    user_id=user,
                    created_us=now,
                    used_us=now,
                    address=address[:200],
                    agent=agent[:200],
                    provider=provider,
                )
            )
            await connection.execute(update(users).where(users.c.id == user).values(used_us=now))
            found = await self._read_sessions(connection, [hashed])
        if not provider:
            # Whoever signs in here has just given all that can be asked for.
            self.confirm_session(hashed)
        return token, found[hashed]

    def confirm_session(self, hashed: str) -> None:
        """Its person has proved anew that it is them."""
        self._confirmations.confirm(hashed, self._clock.monotonic_ns())

    def is_confirmed(self, hashed: str) -> bool:
        """Tell whether its person has proved a short while ago that it is them."""
        return self._confirmations.is_fresh(hashed, self._clock.monotonic_ns())

    async def find_session(self, token: str, *, used: bool = True) -> LiveSession | None:
        """Tell who holds ``token``; None when it stands for no living session.

        Args:
            token: what the cookie holds.
            used: whether a person has done something, so that the idle time begins anew.

        """
        hashed = hash_token(token)
        found = (await self.live_sessions([hashed])).get(hashed)
        if found is None or not used:
            return found
        return found._replace(idle_ends_us=await self.mark_used([found]))

    async def live_sessions(self, hashes: Collection[str]) -> dict[str, LiveSession]:
        """Give those of the sessions that are alive, with their people's rights of now."""
        if not hashes:
            return {}
        async with self._database.read() as connection:
            return await self._read_sessions(connection, hashes)

    async def mark_used(self, used: Collection[LiveSession]) -> int:
        """Write down that sessions are used; give when they end if nobody does any more (µs)."""
        now = self._now_us()
        old = [session.who for session in used if session.used_us < now - _TOUCH_US]
        if old:
            async with self._database.write() as connection:
                await connection.execute(
                    update(sessions)
                    .where(sessions.c.token_hash.in_([who.session for who in old]))
                    .values(used_us=now)
                )
                await connection.execute(
                    update(users)
                    .where(users.c.id.in_([who.user for who in old]))
                    .values(used_us=now)
                )
        return now + self._idle_us

    async def sessions_of(self, user: int) -> list[OpenSession]:
        """List the living sessions of a person, the last used first."""
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(
                    sessions.c.token_hash,
                    sessions.c.created_us,
                    sessions.c.used_us,
                    sessions.c.address,
                    sessions.c.agent,
                )
                .where(sessions.c.user_id == user, self.alive_now())
                .order_by(sessions.c.used_us.desc(), sessions.c.token_hash)
            )
            return [OpenSession(*row) for row in rows]

    async def end_of(self, user: int, hashed: str) -> bool:
        """End one session of a person; False when they have none of that name."""
        # With the person's number too: nobody ends another's session by its hash.
        async with self._database.write() as connection:
            gone = await connection.execute(
                delete(sessions).where(sessions.c.token_hash == hashed, sessions.c.user_id == user)
            )
        return bool(gone.rowcount)

    async def end_session(self, hashed: str) -> None:
        """End one session."""
        async with self._database.write() as connection:
            await connection.execute(delete(sessions).where(sessions.c.token_hash == hashed))

    async def end_all(self, user: int, keep: str = "") -> None:
        """End every session of a person but ``keep``."""
        async with self._database.write() as connection:
            await connection.execute(
                delete(sessions).where(sessions.c.user_id == user, sessions.c.token_hash != keep)
            )

    async def _read_sessions(
        self, connection: AsyncConnection, hashes: Collection[str]
    ) -> dict[str, LiveSession]:
        # A person who is disabled is out at once, whatever sessions they have.
        rows = await connection.execute(
            _LIVE_SESSIONS, {"hashes": list(hashes), **self._alive_after()}
        )
        people = rows.all()
        held = await grants_of(connection, OF_ROLES, {row.role_id for row in people})
        return {
            row.token_hash: LiveSession(
                Who(
                    row.token_hash,
                    row.id,
                    row.name,
                    row.role,
                    held[row.role_id],
                    factor=bool(row.factor),
                    factor_required=bool(row.factor_required) and not row.provider,
                ),
                row.used_us + self._idle_us,
                row.created_us + self._life_us,
                row.used_us,
                row.code_alert_us,
                bool(row.password_hash),
            )
            for row in people
        }

    def alive_now(self) -> ColumnElement[bool]:
        """Give the condition by which a session counts."""
        after = self._alive_after()
        return and_(
            sessions.c.used_us > after["used_after"], sessions.c.created_us > after["begun_after"]
        )

    def _alive_after(self) -> dict[str, int]:
        """Give after when it must have been used and begun (µs); settings hold for open ones."""
        now_us = self._now_us()
        return {"used_after": now_us - self._idle_us, "begun_after": now_us - self._life_us}

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000
