"""What the leads of two shards say to each other while a site goes from one to the other.

All of it stands in the site's row beside the accounts, where both read and write. Each word is
written only where the one before it stands, so of two that would exclude each other one is.
"""

from __future__ import annotations

import secrets
from enum import StrEnum
from typing import TYPE_CHECKING

from sqlalchemy import or_, select, update

from talaia.hub.store.history_servers.history_homes import HistoryHome
from talaia.hub.store.history_servers.home_tables import NOBODY, history_homes

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from talaia.hub.store.database import Database

__all__ = ["HoldWord", "ShardHandover", "with_word", "word_of"]

_home = history_homes


class HoldWord(StrEnum):
    """How far two leads are; each asks, and the other one answers."""

    # The one that it goes to: make blocks of what is in memory, of which most is copied before
    # anybody waits.
    SEAL = "seal"
    # The one that it comes from: it is done.
    SEALED = "sealed"
    # Write nothing of it any more.
    HOLD = "hold"
    # Nothing is written, and all of it is in the database.
    HELD = "held"


def _make_hold() -> str:
    """Give what stands there first; it differs from that of any other attempt."""
    return f"{HoldWord.SEAL} {secrets.token_hex(8)}"


def word_of(hold: str) -> str:
    """Give how far it is; empty: nothing is said."""
    return hold.partition(" ")[0]


def with_word(hold: str, word: HoldWord) -> str:
    """Give what stands there once a word is said in the same attempt."""
    return f"{word} {hold.partition(' ')[2]}"


class ShardHandover:
    """The words in the rows of all sites that change their shard."""

    def __init__(self, database: Database) -> None:
        """Use the accounts' database."""
        self._database = database

    async def list_changing(self) -> list[HistoryHome]:
        """List the sites that move, or whose shard changes.

        Raises:
            StoreDown: the database does not answer.

        """
        query = select(_home).where(
            or_(_home.c.moving_to != "", _home.c.hold != "", _home.c.led_by != "")
        )
        async with self._database.read() as connection:
            rows = (await connection.execute(query.order_by(_home.c.site))).all()
        return [HistoryHome._make(row) for row in rows]

    async def begin_hold(self, home: HistoryHome) -> HistoryHome | None:
        """Ask the other lead to begin, in place of what was said before; None: it moves no more.

        Raises:
            StoreDown: the database does not answer.

        """
        return await self._write_hold(home, None, _make_hold())

    async def write_word(self, home: HistoryHome, word: HoldWord) -> HistoryHome | None:
        """Say the next word; None: what was said before does not stand there any more.

        Raises:
            StoreDown: it is not known whether it is said.

        """
        return await self._write_hold(home, home.hold, with_word(home.hold, word))

    async def end_hold(self, home: HistoryHome) -> HistoryHome | None:
        """Take back what was said in the attempt of ``home.hold``, unless the site has moved.

        Gives what stands then.

        Raises:
            StoreDown: it is not known whether it is taken back.

        """
        async with self._database.write() as connection:
            await connection.execute(
                update(_home)
                # Whichever word of it stands there: of the last one it may not be known.
                .where(
                    _home.c.site == home.site,
                    _home.c.hold.in_([with_word(home.hold, word) for word in HoldWord]),
                )
                .values(hold="")
            )
            row = (
                await connection.execute(select(_home).where(_home.c.site == home.site))
            ).one_or_none()
        return None if row is None else HistoryHome._make(row)

    async def end_holds(self, servers: Collection[str]) -> None:
        """Take back all that was said of sites on some servers: the lead that said it has ended.

        Raises:
            StoreDown: the database does not answer.

        """
        async with self._database.write() as connection:
            await connection.execute(
                update(_home).where(_home.c.server.in_(servers), _home.c.hold != "").values(hold="")
            )

    async def pass_on(self, is_own: Callable[[str], bool]) -> list[str]:
        """Let go of sites that are a shard's no more, and take those that were let go.

        Called by a lead that begins: nothing of it has a site in memory yet. ``is_own`` tells
        whether a server is of its shard.

        Returns:
            Sites that it is to have, of which the lead of before has not let go yet.

        Raises:
            StoreDown: the database does not answer.

        """
        awaited = []
        async with self._database.write() as connection:
            rows = (await connection.execute(select(_home).where(_home.c.led_by != ""))).all()
            for home in map(HistoryHome._make, rows):
                mine = is_own(home.server)
                led_by = home.led_by
                if led_by != NOBODY and is_own(led_by):
                    led_by = NOBODY
                if led_by == NOBODY and mine:
                    led_by = ""
                if led_by != home.led_by:
                    await connection.execute(
                        update(_home).where(_home.c.site == home.site).values(led_by=led_by)
                    )
                elif mine:
                    awaited.append(home.site)
        return awaited

    async def _write_hold(
        self, home: HistoryHome, before: str | None, after: str
    ) -> HistoryHome | None:
        known = () if before is None else (_home.c.hold == before,)
        async with self._database.write() as connection:
            result = await connection.execute(
                update(_home)
                .where(_home.c.site == home.site, _home.c.move == home.move)
                .where(_home.c.server == home.server, _home.c.moving_to == home.moving_to, *known)
                .values(hold=after)
            )
        return home._replace(hold=after) if result.rowcount == 1 else None
