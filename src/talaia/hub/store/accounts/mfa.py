"""Second factors in the database: a sealed secret, the last code used, and recovery codes.

Many wrong codes one after the other lock the codes of time for a while: six digits could be found
by who knows the password and has days. Recovery codes and passkeys, which cannot, still open.
"""

from __future__ import annotations

from enum import Enum, auto
from typing import TYPE_CHECKING

from sqlalchemy import delete, func, select, update

from talaia.hub.auth.totp import hash_recovery, new_factor, step_of
from talaia.hub.errors import PasskeyRefused, UnknownPerson
from talaia.hub.store.accounts.account_notices import add_account_notice
from talaia.hub.store.accounts.passkeys import replace_recovery_codes
from talaia.hub.store.tables import passkeys, recovery_codes, users

if TYPE_CHECKING:
    from collections.abc import Callable

    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.clock import Clock
    from talaia.hub.auth.secret_box import Seal
    from talaia.hub.store.database import Database

__all__ = ["LOCK_S", "WRONG_CODES", "CodeVerdict", "SecondFactors"]

# So many wrong codes without a right one between them lock the codes of time, for so long (s).
WRONG_CODES = 10
LOCK_S = 3600


class CodeVerdict(Enum):
    """What became of a code."""

    RIGHT = auto()
    # It was right, instead of a code of time, and is used up now.
    RECOVERY = auto()
    WRONG = auto()
    # It was used already; the next one is taken.
    REPLAYED = auto()
    # Too many were wrong: it was not looked at.
    LOCKED = auto()
    # It was wrong, and one too many: none is looked at for a while.
    LOCKS = auto()


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
            return await replace_recovery_codes(connection, user)

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
                # So much chance is not guessed: it opens while codes of time are locked, too.
                return CodeVerdict.RECOVERY
            now_us = round(self._now_s() * 1e6)
            if await _read_number(connection, user, "code_locked_us") > now_us:
                return CodeVerdict.LOCKED
            sealed = await _read_column(connection, user, "factor_secret")
            secret = self._seal().open_text(sealed, _factor_context(user)) if sealed else None
            step = step_of(secret, code, self._now_s()) if secret else None
            if step is None:
                return await _count_wrong(connection, user, now_us)
            # A step is accepted once: a code that was overheard is of no use (RFC 6238, 5.2).
            taken = await connection.execute(
                update(users)
                .where(users.c.id == user, users.c.factor_step < step)
                .values(factor_step=step, code_wrong=0)
            )
        return CodeVerdict.RIGHT if taken.rowcount else CodeVerdict.REPLAYED

    async def remove_factor(self, user: int) -> bool:
        """Take all of a person's factors and recovery codes away; False when there was none.

        Raises:
            UnknownPerson: there is nobody of that number.

        """
        async with self._database.write() as connection:
            had = await _read_column(connection, user, "factor_secret")
            gone = await connection.execute(delete(passkeys).where(passkeys.c.user_id == user))
            await _forget_codes(connection, user)
            await connection.execute(delete(recovery_codes).where(recovery_codes.c.user_id == user))
        return bool(had) or bool(gone.rowcount)

    async def remove_codes(self, user: int, *, keep_one: bool) -> bool:
        """Take the codes of time away, not the passkeys; False when there were none.

        Args:
            user: whose.
            keep_one: refuse when the person would be left without a second factor.

        Raises:
            PasskeyRefused: they would.

        """
        async with self._database.write() as connection:
            if not await _read_column(connection, user, "factor_secret"):
                return False
            own = select(func.count()).select_from(passkeys).where(passkeys.c.user_id == user)
            others = (await connection.execute(own)).scalar_one()
            if keep_one and not others:
                raise PasskeyRefused("your role requires a second factor", "add a passkey first")
            await _forget_codes(connection, user)
            # Those of a person with passkeys still open in place of one that is lost.
            if not others:
                await connection.execute(
                    delete(recovery_codes).where(recovery_codes.c.user_id == user)
                )
        return True

    async def has_codes(self, user: int) -> bool:
        """Tell whether a person has an authenticator that makes codes of time."""
        async with self._database.read() as connection:
            return bool(await _read_column(connection, user, "factor_secret"))

    async def see_alert(self, user: int) -> None:
        """The person has read that somebody tried codes."""
        async with self._database.write() as connection:
            await connection.execute(
                update(users).where(users.c.id == user).values(code_alert_us=0)
            )

    def _now_s(self) -> float:
        return self._clock.wall_ns() / 1e9


def _factor_context(user: int) -> str:
    return f"second factor of person {user}"


async def _count_wrong(connection: AsyncConnection, user: int, now_us: int) -> CodeVerdict:
    wrong = await _read_number(connection, user, "code_wrong") + 1
    if wrong < WRONG_CODES:
        await connection.execute(update(users).where(users.c.id == user).values(code_wrong=wrong))
        return CodeVerdict.WRONG
    await connection.execute(
        update(users)
        .where(users.c.id == user)
        .values(code_wrong=0, code_locked_us=now_us + LOCK_S * 1_000_000, code_alert_us=now_us)
    )
    # With the lock or not at all: nobody is locked without being told.
    await add_account_notice(
        connection,
        user,
        title="Wrong codes for your account",
        text=(
            f"{wrong} wrong codes of your second factor were given, by somebody who knows your"
            " password. Codes are not taken for an hour; a recovery code or a passkey is. If it was"
            " not you, change your password."
        ),
        now_us=now_us,
    )
    return CodeVerdict.LOCKS


async def _forget_codes(connection: AsyncConnection, user: int) -> None:
    await connection.execute(
        update(users)
        .where(users.c.id == user)
        .values(factor_secret="", factor_pending="", factor_step=0, code_wrong=0, code_locked_us=0)
    )


async def _read_number(connection: AsyncConnection, user: int, name: str) -> int:
    return int(await _read_column(connection, user, name))


async def _read_column(connection: AsyncConnection, user: int, name: str) -> str:
    found = (await connection.execute(select(users.c[name]).where(users.c.id == user))).scalar()
    if found is None:
        raise UnknownPerson("there is no such person")
    return str(found)
