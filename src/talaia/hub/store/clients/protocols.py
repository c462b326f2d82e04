"""Which client protocols an admin has opened, to which origins, and who may drive by them."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import delete, insert, select

from talaia.hub.store.tables import client_drivers, client_protocols, users

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.clock import Clock
    from talaia.hub.store.database import Database

__all__ = ["ClientDriver", "ClientProtocols", "ProtocolState"]


class ProtocolState(NamedTuple):
    """How an admin has set one protocol.

    Attributes:
        protocol: its short name.
        open: clients may connect.
        origins: pages of these may, too.
        changed_by: who set it so last.
        changed_us: when (UTC).

    """

    protocol: str
    open: bool
    origins: tuple[str, ...]
    changed_by: str
    changed_us: int


class ClientDriver(NamedTuple):
    """An account that may drive a device by such clients; by whom it was let, and when (UTC)."""

    user: int
    name: str
    site: str
    device: str
    given_by: str
    given_us: int


class ClientProtocols:
    """The two tables; a protocol without a row is shut."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` stamps changes."""
        self._database = database
        self._clock = clock

    async def read_states(self) -> list[ProtocolState]:
        """Give the protocols that were ever set, in the order of their names.

        Raises:
            StoreDown: the database does not answer.

        """
        async with self._database.read() as connection:
            return await _states_in(connection)

    async def read_permitted(self) -> tuple[list[ProtocolState], frozenset[tuple[int, str, str]]]:
        """Give the protocols, and who may drive: an account's number, a site and a device each.

        In one transaction and without names, for it is asked again and again.

        Raises:
            StoreDown: the database does not answer.

        """
        drivers = select(client_drivers.c.user_id, client_drivers.c.site, client_drivers.c.device)
        async with self._database.read() as connection:
            states = await _states_in(connection)
            rows = (await connection.execute(drivers)).all()
        return states, frozenset((row.user_id, row.site, row.device) for row in rows)

    async def set_state(
        self, protocol: str, *, is_open: bool, origins: Sequence[str], who: str
    ) -> None:
        """Open or shut a protocol, and name the origins that are let in.

        Raises:
            StoreDown: the database does not answer; nothing has changed.

        """
        # Deleted and written: one way for the first time and for later ones.
        mine = client_protocols.c.protocol == protocol
        async with self._database.write() as connection:
            await connection.execute(delete(client_protocols).where(mine))
            await connection.execute(
                insert(client_protocols).values(
                    protocol=protocol,
                    is_open=is_open,
                    origins=json.dumps(list(origins)),
                    changed_by=who,
                    changed_us=self._clock.wall_ns() // 1000,
                )
            )

    async def read_drivers(self) -> list[ClientDriver]:
        """Give who may drive what by such clients, in the order of names.

        Raises:
            StoreDown: the database does not answer.

        """
        chosen = (
            select(
                client_drivers.c.user_id,
                users.c.name,
                client_drivers.c.site,
                client_drivers.c.device,
                client_drivers.c.given_by,
                client_drivers.c.given_us,
            )
            .join(users, users.c.id == client_drivers.c.user_id)
            .order_by(users.c.name, client_drivers.c.site, client_drivers.c.device)
        )
        async with self._database.read() as connection:
            rows = (await connection.execute(chosen)).all()
        return [ClientDriver(*row) for row in rows]

    async def set_driver(
        self, user: int, site: str, device: str, *, allowed: bool, who: str
    ) -> str | None:
        """Let an account drive a device by such clients, or no more; give its name.

        Returns:
            None when there is no such account.

        """
        mine = (
            client_drivers.c.user_id == user,
            client_drivers.c.site == site,
            client_drivers.c.device == device,
        )
        async with self._database.write() as connection:
            name = (
                await connection.execute(select(users.c.name).where(users.c.id == user))
            ).scalar()
            # Not an error of the database: the person may have been removed a moment ago.
            if name is None:
                return None
            await connection.execute(delete(client_drivers).where(*mine))
            if allowed:
                await connection.execute(
                    insert(client_drivers).values(
                        user_id=user,
                        site=site,
                        device=device,
                        given_by=who,
                        given_us=self._clock.wall_ns() // 1000,
                    )
                )
        return str(name)


async def _states_in(connection: AsyncConnection) -> list[ProtocolState]:
    chosen = select(client_protocols).order_by(client_protocols.c.protocol)
    # Booleans are numbers in MariaDB and SQLite.
    return [
        ProtocolState(
            row.protocol,
            bool(row.is_open),
            tuple(json.loads(row.origins)),
            row.changed_by,
            row.changed_us,
        )
        for row in (await connection.execute(chosen)).all()
    ]
