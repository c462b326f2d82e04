"""Second factors in the database: a sealed secret, the last code used, and recovery codes."""

from __future__ import annotations

from enum import Enum, auto
from typing import TYPE_CHECKING

from sqlalchemy import delete, insert, select, update

from talaia.hub.auth.totp import hash_recovery, new_factor, new_recovery, step_of
from talaia.hub.errors import UnknownPerson
from talaia.hub.store.tables import recovery_codes, users

if TYPE_CHECKING:
    from collections.abc import Callable

    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.clock import Clock
    from talaia.hub.auth.secret_box import Seal
    from talaia.hub.store.database import Database

__all__ = ["CodeVerdict", "SecondFactors"]


class CodeVerdict(Enum):
    """What became of a code."""

    RIGHT = auto()
    # It was right, instead of a code of time, and is used up now.
    RECOVERY = auto()
    WRONG = auto()
    # It was used already; the next one is taken.
    REPLAYED = auto()


class SecondFactors:
    """Sets up, asks for and removes second factors."""

    def __init__(self, database: Database, clock: Clock, seal: Callable[[], Seal]) -> None:
        """Keep secrets under the seal that ``seal`` gives, when there is one to keep."""
        self._database = database
        self._clock = clock
        # Secrets are sealed in the database: who reads a backup cannot make codes.
        self._seal = seal

    async def offer_factor(self, user: int) -> str | None:
        """Make a secret that waits for its first code; None when there is a factor already."""
        secret = new_factor()
        async with self._database.write() as connection:
            # A factor in use is removed first: whoever takes over a session cannot put theirs in
            # its place.
            if await _read_column(connection, user, "factor_secret"):
                return None
            await connection.execute(
                update(users)
                .where(users.c.id == user)
                .values(factor_pending=self._seal().seal_text(secret, _factor_context(user)))
            )
        return secret

    async def confirm_factor(self, user: int, code: str) -> list[str] | None:
        """Switch the offered factor on by its first code; give the recovery codes.

        Returns:
            None when the code is wrong, or nothing was offered.

        """
        async with self._database.write() as connection:
            pending = await _read_column(connection, user, "factor_pending")
            secret = self._seal().open_text(pending, _factor_context(user)) if pending else None
            step = step_of(secret, code, self._now_s()) if secret else None
            if step is None:
                return None
            # The code that confirmed it is used up, and so is its step.
            await connection.execute(
                update(users)
                .where(users.c.id == user)
                .values(factor_secret=pending, factor_pending="", factor_step=step)
            )
            codes = new_recovery()
            await connection.execute(delete(recovery_codes).where(recovery_codes.c.user_id == user))
            await connection.execute(
                insert(recovery_codes),
                [{"code_hash": hash_recovery(one), "user_id": user} for one in codes],
            )
        return codes

    async def use_code(self, user: int, code: str) -> CodeVerdict:
        """Take a code of time, or a recovery code, each at most once."""
        async with self._database.write() as connection:
            # Deleting is the test: of two that use one code at once only one deletes it.
            gone = await connection.execute(
                delete(recovery_codes).where(
                    recovery_codes.c.user_id == user,
                    recovery_codes.c.code_hash == hash_recovery(code),
                )
            )
            if gone.rowcount:
                return CodeVerdict.RECOVERY
            sealed = await _read_column(connection, user, "factor_secret")
            secret = self._seal().open_text(sealed, _factor_context(user)) if sealed else None
            step = step_of(secret, code, self._now_s()) if secret else None
            if step is None:
                return CodeVerdict.WRONG
            # A step is accepted once: a code that was overheard is of no use (RFC 6238, 5.2).
            taken = await connection.execute(
                update(users)
                .where(users.c.id == user, users.c.factor_step < step)
                .values(factor_step=step)
            )
        return CodeVerdict.RIGHT if taken.rowcount else CodeVerdict.REPLAYED

    async def remove_factor(self, user: int) -> bool:
        """Take a person's factor and recovery codes away; False when there was none.

        Raises:
            UnknownPerson: there is nobody of that number.

        """
        async with self._database.write() as connection:
            had = await _read_column(connection, user, "factor_secret")
            await connection.execute(
                update(users)
                .where(users.c.id == user)
                .values(factor_secret="", factor_pending="", factor_step=0)
            )
            await connection.execute(delete(recovery_codes).where(recovery_codes.c.user_id == user))
        return bool(had)

    def _now_s(self) -> float:
        return self._clock.wall_ns() / 1e9


def _factor_context(user: int) -> str:
    return f"second factor of person {user}"


async def _read_column(connection: AsyncConnection, user: int, name: str) -> str:
    found = (await connection.execute(select(users.c[name]).where(users.c.id == user))).scalar()
    if found is None:
        raise UnknownPerson("there is no such person")
    return str(found)
