"""Wrong sign-ins that outlast a restart of the hub."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import delete, insert, select

from talaia.hub.auth.throttle import FORGET_NS, AttemptKind, CountedAttempts
from talaia.hub.store.tables import wrong_tries

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.auth.throttle import Throttle
    from talaia.hub.store.database import Database

__all__ = ["FailedLogins"]


class FailedLogins:
    """Keeps what a throttle counts."""

    def __init__(self, database: Database, clock: Clock, throttle: Throttle) -> None:
        """Keep the counts of ``throttle``."""
        self._database = database
        self._clock = clock
        # What it counts is in memory, and kept here so that a restart forgets nothing.
        self._throttle = throttle

    async def bring_back(self) -> None:
        """Let the throttle remember what was counted before the hub was started."""
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(wrong_tries)
                .where(wrong_tries.c.last_us > self._oldest_us())
                .order_by(wrong_tries.c.last_us)
            )
            self._throttle.bring_back(
                CountedAttempts(AttemptKind(row.kind), row.key_hash, row.wrong, row.last_us * 1000)
                for row in rows
            )

    async def count_attempt(self, user: str, address: str, browser: str) -> int:
        """Count a try as wrong and give 0, or how long to wait (ns) and count nothing."""
        now = self._clock.wall_ns()
        # Asked and counted without a pause between: many at once must not slip through.
        wait_ns = self._throttle.wait_ns(user, address, now, browser)
        if not wait_ns:
            self._throttle.count_attempt(user, address, now, browser)
            await self.save_counts()
        return wait_ns

    async def count_unfinished(self, user: str, address: str, browser: str) -> None:
        """Take a counted try for the first half of a sign-in, and not for a wrong one."""
        self._throttle.uncount_attempt(user, address, browser)
        await self.save_counts()

    async def count_success(self, user: str, address: str, browser: str) -> None:
        """Forget the wrong tries of one who has proved who they are."""
        self._throttle.clear_attempts(user, address, browser)
        await self.save_counts()

    async def save_counts(self) -> None:
        """Write down what was counted since."""
        changes = self._throttle.changed_attempts()
        if not changes:
            return
        counted = [
            {
                "kind": change.kind.value,
                "key_hash": change.key,
                "wrong": change.wrong,
                "last_us": change.last_ns // 1000,
            }
            for change in changes
            if change.wrong
        ]
        async with self._database.write() as connection:
            await connection.execute(
                delete(wrong_tries).where(wrong_tries.c.last_us <= self._oldest_us())
            )
            # Deleted, then inserted: every engine has its own words for doing both at once.
            for change in changes:
                await connection.execute(
                    delete(wrong_tries).where(
                        wrong_tries.c.kind == change.kind.value,
                        wrong_tries.c.key_hash == change.key,
                    )
                )
            if counted:
                await connection.execute(insert(wrong_tries), counted)

    def _oldest_us(self) -> int:
        return (self._clock.wall_ns() - FORGET_NS) // 1000
