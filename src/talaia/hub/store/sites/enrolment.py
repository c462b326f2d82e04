"""One-time codes by which gateways enrol: kept as hashes, good for minutes, used once."""

from __future__ import annotations

import asyncio
import hashlib
import secrets
from enum import Enum
from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import delete, insert, select, update

from talaia.hub.store.sites.site_registry import add_key
from talaia.hub.store.tables import enrolment_codes as codes
from talaia.wire.enrolment import secret_of

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.store.database import Database

__all__ = ["CODE_LIFE_US", "Enrolled", "Enrolment", "EnrolmentRefusal", "OpenCode"]

CODE_LIFE_US = 15 * 60 * 1_000_000
# For so long after its end a code is told from one that never was.
_REMEMBER_US = 86_400 * 1_000_000
# A code has 60 bits. With this it cannot be found from its hash while it lives.
_COST = {"n": 2**13, "r": 8, "p": 1}
_SALT = b"talaia enrolment code v1"
_AT_ONCE = 2


class EnrolmentRefusal(Enum):
    """Why a code is not taken."""

    UNKNOWN = "unknown"
    EXPIRED = "expired"
    USED = "used"


class OpenCode(NamedTuple):
    """A code that can be used; what it says itself is not kept."""

    id: int
    site: str
    name: str
    created_us: int
    expires_us: int


class Enrolled(NamedTuple):
    """A gateway that has just enrolled, its key, and those whose keys are void since."""

    gateway: int
    site: str
    key: str
    replaced: list[int]


class Enrolment:
    """Makes codes, and takes each one once."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` says when a code ends."""
        self._database = database
        self._clock = clock
        self._gate = asyncio.Semaphore(_AT_ONCE)

    async def offer_code(self, site: str, name: str = "") -> tuple[OpenCode, str]:
        """Make a code for a gateway of ``site``; give it with its secret, told once."""
        secret = secret_of(secrets.randbits(60))
        hashed = await self._hash_in_thread(secret)
        now = self._now_us()
        said = {
            "site": site,
            "name": name[:200],
            "created_us": now,
            "expires_us": now + CODE_LIFE_US,
        }
        async with self._database.write() as connection:
            await connection.execute(delete(codes).where(codes.c.expires_us < now - _REMEMBER_US))
            made = await connection.execute(
                insert(codes).values(code_hash=hashed, used_us=0, **said)
            )
        number = made.inserted_primary_key
        return OpenCode(
            int(number[0]) if number else 0, site, name, now, now + CODE_LIFE_US
        ), secret

    async def list_open(self) -> list[OpenCode]:
        """List the codes that can be used now, the newest first."""
        columns = (codes.c[name] for name in OpenCode._fields)
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(*columns)
                .where(codes.c.used_us == 0, codes.c.expires_us > self._now_us())
                .order_by(codes.c.id.desc())
            )
            return [OpenCode(*row) for row in rows]

    async def withdraw_code(self, number: int) -> OpenCode | None:
        """Take back a code that was not used; None when there is none."""
        columns = (codes.c[name] for name in OpenCode._fields)
        unused = (codes.c.id == number, codes.c.used_us == 0)
        async with self._database.write() as connection:
            row = (await connection.execute(select(*columns).where(*unused))).first()
            if row is None:
                return None
            done = await connection.execute(delete(codes).where(*unused))
        return OpenCode(*row) if done.rowcount else None

    async def redeem_code(self, secret: str, name: str) -> Enrolled | EnrolmentRefusal:
        """Use a code: of two at once exactly one gets a key.

        Args:
            secret: of the code.
            name: what the gateway calls itself, where the code was made without a name.

        """
        hashed = await self._hash_in_thread(secret)
        now = self._now_us()
        async with self._database.write() as connection:
            used = await connection.execute(
                update(codes)
                .where(codes.c.code_hash == hashed, codes.c.used_us == 0, codes.c.expires_us > now)
                .values(used_us=now)
            )
            found = await connection.execute(
                select(codes.c.site, codes.c.name, codes.c.used_us).where(
                    codes.c.code_hash == hashed
                )
            )
            row = found.first()
            if row is None:
                return EnrolmentRefusal.UNKNOWN
            # The database has counted the one row that it changed: of two at once, for one only.
            if used.rowcount != 1:
                return EnrolmentRefusal.USED if row.used_us else EnrolmentRefusal.EXPIRED
            gateway, key, replaced = await add_key(connection, row.site, row.name or name, now)
        return Enrolled(gateway, row.site, key, replaced)

    async def _hash_in_thread(self, secret: str) -> str:
        async with self._gate:
            return await asyncio.to_thread(_hash_secret, secret)

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000


def _hash_secret(secret: str) -> str:
    return hashlib.scrypt(secret.encode(), salt=_SALT, dklen=32, **_COST).hex()
