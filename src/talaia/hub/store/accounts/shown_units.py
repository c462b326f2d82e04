"""In which units people want to see values: their own choice, kept in the account."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from sqlalchemy import select, update

from talaia.hub.store.tables import users

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.hub.auth.permissions import Who
    from talaia.hub.store.database import Database

__all__ = ["ShownUnits"]


class ShownUnits:
    """Stored unit to shown unit, of each person."""

    def __init__(self, database: Database) -> None:
        """Work on ``database``."""
        self._database = database

    async def choice_of(self, who: Who) -> dict[str, str]:
        """Give what somebody chose; nothing of a display, which is nobody's."""
        if who.display:
            return {}
        async with self._database.read() as connection:
            found = await connection.execute(
                select(users.c.shown_units).where(users.c.id == who.user)
            )
            text = found.scalar()
        return {} if text is None else {str(a): str(b) for a, b in json.loads(text).items()}

    async def choose(self, user: int, choice: Mapping[str, str]) -> None:
        """Replace a person's choice."""
        text = json.dumps(dict(choice), ensure_ascii=False)
        async with self._database.write() as connection:
            await connection.execute(
                update(users).where(users.c.id == user).values(shown_units=text)
            )
