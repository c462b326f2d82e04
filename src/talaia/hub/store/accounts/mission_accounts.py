"""The accounts with whose rights missions run: as they are at that moment, without a sign-in."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import select

from talaia.hub.auth.permissions import Who
from talaia.hub.store.accounts.permission_grants import OF_ROLES, grants_of
from talaia.hub.store.accounts.sessions import LiveSession
from talaia.hub.store.tables import roles, users

if TYPE_CHECKING:
    from collections.abc import Collection

    from talaia.hub.store.database import Database

__all__ = ["MissionAccounts"]

# What names such an account among the names of sessions.
_NAMED = "mission:"
# It has no end of its own: it is asked anew each second whether the account is still good.
_NEVER_US = 2**53


class MissionAccounts:
    """Accounts by the names that a mission's `Who` carries."""

    def __init__(self, database: Database) -> None:
        """Look in ``database``."""
        self._database = database

    async def find_account(self, user: int) -> Who | None:
        """Give an account with its rights of now; None when it is disabled or gone.

        Raises:
            StoreDown: it cannot be told.

        """
        key = f"{_NAMED}{user}"
        found = (await self.live_sessions([key])).get(key)
        return None if found is None else found.who

    async def live_sessions(self, keys: Collection[str]) -> dict[str, LiveSession]:
        """Give those of the accounts that are good, with their rights of now."""
        wanted = {
            int(key.removeprefix(_NAMED))
            for key in keys
            if key.startswith(_NAMED) and key.removeprefix(_NAMED).isdecimal()
        }
        if not wanted:
            return {}
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(users.c.id, users.c.name, users.c.role_id, roles.c.name.label("role"))
                .join(roles, roles.c.id == users.c.role_id)
                .where(users.c.id.in_(wanted), ~users.c.disabled)
            )
            people = rows.all()
            held = await grants_of(connection, OF_ROLES, {row.role_id for row in people})
        return {
            # A script: nobody sits there. What a script may not do, a mission may not either.
            f"{_NAMED}{row.id}": LiveSession(
                Who(
                    f"{_NAMED}{row.id}",
                    row.id,
                    row.name,
                    row.role,
                    held[row.role_id],
                    script=True,
                ),
                _NEVER_US,
                _NEVER_US,
                _NEVER_US,
            )
            for row in people
        }
