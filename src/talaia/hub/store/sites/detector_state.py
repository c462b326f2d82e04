"""What anomaly detectors have learned, kept over a restart."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import delete, insert, select

from talaia.hub.store.tables import learned

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.clock import Clock
    from talaia.hub.store.database import Database

__all__ = ["DetectorState"]


class DetectorState:
    """Rows of bytes by site, address and detector."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` says when a row was written."""
        self._database = database
        self._clock = clock

    async def states_of(self, site: str) -> dict[tuple[str, str], bytes]:
        """Give everything kept of a site, by address and detector.

        Raises:
            StoreDown: the database does not answer.

        """
        async with self._database.read() as connection:
            rows = await connection.execute(select(learned).where(learned.c.site == site))
            return {(row.address, row.detector): row.state for row in rows}

    async def states_named(self, name: tuple[str, str]) -> dict[str, bytes]:
        """Give what every site keeps under one address and detector, by site.

        Raises:
            StoreDown: the database does not answer.

        """
        address, detector = name
        query = select(learned.c.site, learned.c.state).where(
            learned.c.address == address, learned.c.detector == detector
        )
        async with self._database.read() as connection:
            return {row.site: row.state for row in await connection.execute(query)}

    async def save_states(self, rows: Sequence[tuple[str, str, str, bytes]]) -> None:
        """Keep states in place of those before: site, address, detector, bytes.

        Raises:
            StoreDown: the database does not answer, or has no room; nothing of it was kept.

        """
        if not rows:
            return
        now_us = self._clock.wall_ns() // 1000
        async with self._database.write() as connection:
            for site, address, detector, state in rows:
                key = {"site": site, "address": address, "detector": detector}
                same = [learned.c[name] == value for name, value in key.items()]
                await connection.execute(delete(learned).where(*same))
                row = {**key, "state": state, "saved_us": now_us}
                await connection.execute(insert(learned).values(row))
