"""When gateways were there: remembered at once, written together a little later.

Five hundred gateways that come back in one second would otherwise make two thousand transactions
of it, and whoever signs in or drives would wait behind them for the database. What is lost with a
hub that is killed is the last second of "last seen", and nothing else.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from typing import TYPE_CHECKING, Any, TypeVar

from sqlalchemy import bindparam, update
from sqlalchemy.exc import SQLAlchemyError

from talaia.errors import TalaiaError
from talaia.hub.store.tables import gateways, sites

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.clock import Clock
    from talaia.hub.store.database import Database

__all__ = ["GatewayPresence"]

_LOG = logging.getLogger(__name__)
# Pages are told by the hub itself; after a crash this much of "last seen" is missing. Each write is
# a commit that waits for the disk, for as long as a gateway is there.
_EVERY_S = 5.0
_FAILS = (SQLAlchemyError, TalaiaError, OSError)
_Key = TypeVar("_Key", int, str)


class GatewayPresence:
    """What is known of the coming and going of gateways and is not in the database yet."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Write to ``database`` once `run` runs; ``clock`` says when somebody was there."""
        self._database = database
        self._clock = clock
        # By gateway and by site, what is to be written of each.
        self._gateways: dict[int, dict[str, object]] = {}
        self._sites: dict[str, dict[str, object]] = {}
        # Ends the wait between two writes at once.
        self._stopping = asyncio.Event()

    def record_link(self, gateway: int, site: str, version: str, address: str) -> None:
        """Keep that a gateway has linked."""
        self._gateways.setdefault(gateway, {}).update(
            seen_us=self._now_us(), version=version[:200], address=address[:200]
        )
        self._sites.setdefault(site, {}).update(last_seen_us=self._now_us(), version=version[:200])

    def record_leave(self, gateway: int, site: str) -> None:
        """Keep that a gateway was there until now."""
        self._gateways.setdefault(gateway, {})["seen_us"] = self._now_us()
        self._sites.setdefault(site, {})["last_seen_us"] = self._now_us()

    def pending_columns(self, gateway: int) -> Mapping[str, Any]:
        """Give what the database does not know yet of a gateway, by column."""
        return self._gateways.get(gateway, {})

    async def run(self) -> None:
        """Write every few seconds what there is, until `stop`; the last is written then."""
        failing = False
        while not self._stopping.is_set():
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(_EVERY_S):
                    await self._stopping.wait()
            try:
                await self.write_pending()
            except _FAILS as error:
                if not failing:
                    _LOG.error("when gateways were there cannot be kept for now: %s", error)
                failing = True
            else:
                failing = False

    def stop(self) -> None:
        """Let `run` write the last and end."""
        self._stopping.set()

    async def write_pending(self) -> None:
        """Write what there is, in one transaction.

        Raises:
            StoreDown: nothing of it was written; it stays, and is written the next time.

        """
        if not self._gateways and not self._sites:
            return
        # What comes in while this is written has its own turn.
        of_gateways, self._gateways = self._gateways, {}
        of_sites, self._sites = self._sites, {}
        try:
            async with self._database.write() as connection:
                for table, key, said in (
                    (gateways, gateways.c.id, of_gateways),
                    (sites, sites.c.site, of_sites),
                ):
                    for columns in {tuple(sorted(pair)) for pair in said.values()}:
                        rows = [
                            {"_key": name, **{f"_{column}": values[column] for column in columns}}
                            for name, values in said.items()
                            if tuple(sorted(values)) == columns
                        ]
                        change: dict[str, Any] = {
                            column: bindparam(f"_{column}") for column in columns
                        }
                        await connection.execute(
                            update(table).where(key == bindparam("_key")).values(**change), rows
                        )
        except BaseException:
            self._gateways = _merge_pending(of_gateways, self._gateways)
            self._sites = _merge_pending(of_sites, self._sites)
            raise

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000


def _merge_pending(
    older: dict[_Key, dict[str, object]], newer: dict[_Key, dict[str, object]]
) -> dict[_Key, dict[str, object]]:
    return {key: {**older.get(key, {}), **newer.get(key, {})} for key in older | newer}
