"""Who a person of the provider is here: issuer and subject, and the account that is theirs."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

from sqlalchemy import delete, insert, select
from sqlalchemy.exc import IntegrityError

from talaia.hub.errors import NameTaken, NoPassword
from talaia.hub.store.tables import identities, users

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.store.database import Database

__all__ = ["Identities"]


class Identities:
    """Finds and connects them. A name is never enough: names are given anew, subjects are not."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` stamps."""
        self._database = database
        self._clock = clock

    async def person_of(self, issuer: str, subject: str) -> tuple[int, bool] | None:
        """Give a person's number and whether they are disabled; None: nobody is connected."""
        async with self._database.read() as connection:
            found = (
                await connection.execute(
                    select(users.c.id, users.c.disabled)
                    .join(identities, identities.c.user_id == users.c.id)
                    .where(identities.c.key_hash == _key(issuer, subject))
                )
            ).first()
        return None if found is None else (int(found.id), bool(found.disabled))

    async def is_connected(self, user: int) -> bool:
        """Tell whether a person signs in by the provider."""
        async with self._database.read() as connection:
            asked = select(identities.c.key_hash).where(identities.c.user_id == user)
            return (await connection.execute(asked)).first() is not None

    async def disconnect(self, user: int) -> bool:
        """Let a person sign in by it no more; False: they are not connected.

        Raises:
            NoPassword: they would have no way to sign in.

        """
        async with self._database.write() as connection:
            hashed = select(users.c.password_hash).where(users.c.id == user)
            # Asked in the transaction: a passkey alone is no way in under another name of the hub.
            if not (await connection.execute(hashed)).scalar():
                raise NoPassword(
                    "this account has no password, so nobody could sign in to it",
                    "an admin gives it a password first, or disables it",
                )
            gone = await connection.execute(delete(identities).where(identities.c.user_id == user))
        return bool(gone.rowcount)

    async def connect(self, user: int, issuer: str, subject: str) -> None:
        """Let a person sign in by it from now on.

        Raises:
            NameTaken: it is connected with somebody.

        """
        try:
            async with self._database.write() as connection:
                await connection.execute(
                    insert(identities).values(
                        key_hash=_key(issuer, subject),
                        user_id=user,
                        created_us=self._clock.wall_ns() // 1000,
                    )
                )
        except IntegrityError as error:
            raise NameTaken("that account of the provider is connected with somebody") from error


def _key(issuer: str, subject: str) -> str:
    # Neither may hold a NUL, so no two pairs make one text.
    return hashlib.sha256(f"{issuer}\0{subject}".encode("utf-8", "surrogatepass")).hexdigest()
