"""Passkeys in the database: the public halves of keys that people's own devices hold."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import delete, func, insert, or_, select, update

from talaia.hub.auth.passkey_ceremony import RegisteredPasskey
from talaia.hub.auth.totp import hash_recovery, new_recovery
from talaia.hub.errors import PasskeyRefused
from talaia.hub.store.tables import passkeys, recovery_codes, users

if TYPE_CHECKING:
    from sqlalchemy import ColumnElement, RowMapping, Select
    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.clock import Clock
    from talaia.hub.store.database import Database

__all__ = ["KeptPasskey", "Passkeys", "has_factor", "replace_recovery_codes"]

# So many for each person; who needs more has lost count of them.
_MOST = 20


class KeptPasskey(NamedTuple):
    """One of a person's passkeys; ``owner`` is their name. Times in µs (UTC), 0: never."""

    id: int
    user: int
    owner: str
    name: str
    host: str
    created_us: int
    used_us: int
    key: RegisteredPasskey


class Passkeys:
    """Adds, finds and removes them."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` stamps."""
        self._database = database
        self._clock = clock

    async def passkeys_of(self, user: int) -> list[KeptPasskey]:
        """List a person's, the oldest first."""
        async with self._database.read() as connection:
            rows = await connection.execute(
                _select_passkeys().where(passkeys.c.user_id == user).order_by(passkeys.c.id)
            )
            return [_row_to_passkey(row) for row in rows.mappings()]

    async def find_passkey(self, credential_id: str) -> KeptPasskey | None:
        """Find one by the id that browsers know it by."""
        async with self._database.read() as connection:
            rows = await connection.execute(
                _select_passkeys().where(
                    passkeys.c.id_hash == _hash_id(credential_id), ~users.c.disabled
                )
            )
            found = rows.mappings().first()
        return None if found is None else _row_to_passkey(found)

    async def add_passkey(
        self, user: int, name: str, host: str, key: RegisteredPasskey
    ) -> tuple[int, list[str]]:
        """Keep a new one; give its number, and recovery codes where it is the first factor.

        Raises:
            PasskeyRefused: it is kept already, or the person has as many as may be.

        """
        async with self._database.write() as connection:
            first = not await _is_protected(connection, user)
            hashed = _hash_id(key.credential_id)
            taken = select(func.count()).select_from(passkeys).where(passkeys.c.id_hash == hashed)
            if (await connection.execute(taken)).scalar_one():
                raise PasskeyRefused("this passkey is kept already", "use it to sign in")
            count = select(func.count()).select_from(passkeys).where(passkeys.c.user_id == user)
            if (await connection.execute(count)).scalar_one() >= _MOST:
                raise PasskeyRefused(f"you have {_MOST} passkeys", "remove one first")
            added = await connection.execute(
                insert(passkeys).values(
                    user_id=user,
                    name=name,
                    id_hash=hashed,
                    credential_id=key.credential_id,
                    public_key=key.public_key,
                    host=host,
                    sign_count=key.sign_count,
                    created_us=self._clock.wall_ns() // 1000,
                    used_us=0,
                )
            )
            number = added.inserted_primary_key
            # Without codes whoever loses the device would be shut out.
            codes = await replace_recovery_codes(connection, user) if first else []
        return int(number[0]) if number else 0, codes

    async def mark_passkey_used(self, passkey: KeptPasskey, sign_count: int) -> bool:
        """Write down that it has answered; False when its count stands still, as a copy's does."""
        kept = passkeys.c.sign_count
        # Many devices do not count, and always say 0. Compared in the database: of two answers
        # with one count only one holds.
        grows = kept < sign_count if sign_count else kept == 0
        async with self._database.write() as connection:
            marked = await connection.execute(
                update(passkeys)
                .where(passkeys.c.id == passkey.id, grows)
                .values(sign_count=sign_count, used_us=self._clock.wall_ns() // 1000)
            )
        return bool(marked.rowcount)

    async def rename_passkey(self, user: int, passkey: int, name: str) -> str | None:
        """Call one of a person's otherwise; give the name it had, None when they have none such."""
        async with self._database.write() as connection:
            # With the person's number too: nobody renames another's.
            mine = (passkeys.c.id == passkey, passkeys.c.user_id == user)
            before = (await connection.execute(select(passkeys.c.name).where(*mine))).scalar()
            await connection.execute(update(passkeys).where(*mine).values(name=name))
        return before

    async def remove_passkey(self, user: int, passkey: int, *, keep_one: bool) -> str | None:
        """Remove one of a person's; give the name it had, None when they have none such.

        Args:
            user: whose.
            passkey: its number.
            keep_one: refuse when the person would be left without a second factor.

        Raises:
            PasskeyRefused: they would.

        """
        async with self._database.write() as connection:
            # With the person's number too: nobody removes another's.
            mine = (passkeys.c.id == passkey, passkeys.c.user_id == user)
            name = (await connection.execute(select(passkeys.c.name).where(*mine))).scalar()
            if name is None:
                return None
            await connection.execute(delete(passkeys).where(*mine))
            if not await _is_protected(connection, user):
                if keep_one:
                    # Raised in the transaction, which takes the removal back.
                    raise PasskeyRefused(
                        "your role requires a second factor", "set up another one first"
                    )
                await connection.execute(
                    delete(recovery_codes).where(recovery_codes.c.user_id == user)
                )
        return str(name)


def has_factor() -> ColumnElement[bool]:
    """Give the condition that a row of ``users`` is of somebody with a second factor."""
    own = select(passkeys.c.id).where(passkeys.c.user_id == users.c.id).exists()
    return or_(users.c.factor_secret != "", own)


async def replace_recovery_codes(connection: AsyncConnection, user: int) -> list[str]:
    """Give a person new recovery codes; those of before are void."""
    codes = new_recovery()
    await connection.execute(delete(recovery_codes).where(recovery_codes.c.user_id == user))
    await connection.execute(
        insert(recovery_codes),
        [{"code_hash": hash_recovery(one), "user_id": user} for one in codes],
    )
    return codes


async def _is_protected(connection: AsyncConnection, user: int) -> bool:
    found = await connection.execute(select(users.c.id).where(users.c.id == user, has_factor()))
    return found.first() is not None


def _select_passkeys() -> Select[Any]:
    return select(passkeys, users.c.name.label("owner")).join(
        users, users.c.id == passkeys.c.user_id
    )


def _hash_id(credential_id: str) -> str:
    return hashlib.sha256(credential_id.encode("utf-8", "surrogatepass")).hexdigest()


def _row_to_passkey(row: RowMapping) -> KeptPasskey:
    return KeptPasskey(
        row["id"],
        row["user_id"],
        row["owner"],
        row["name"],
        row["host"],
        row["created_us"],
        row["used_us"],
        RegisteredPasskey(row["credential_id"], row["public_key"], row["sign_count"]),
    )
