"""Displays: screens in a hall or a control room that show chosen sites, and can do nothing else.

A display has a token of its own kind. It is no person's: it outlives whoever made it, ends only
when it is revoked, and never has more than the right to view the sites that were chosen.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import delete, func, insert, select, update

from talaia.hub.auth.permissions import Grants, Permission, Right, Who
from talaia.hub.auth.tokens import TOKEN_MARK, hash_token, new_token
from talaia.hub.store.accounts.sessions import LiveSession
from talaia.hub.store.tables import displays

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from talaia.clock import Clock
    from talaia.hub.store.database import Database

__all__ = ["DISPLAY_MARK", "MOST_DISPLAYS", "Display", "Displays"]

# Begins as all tokens do, so that logs are masked of it, and opens nothing where those do.
DISPLAY_MARK = f"{TOKEN_MARK}display_"
MOST_DISPLAYS = 200
# What names a display among the names of sessions.
_NAMED = "display:"
# A use is written down at most so often (µs).
_TOUCH_US = 60_000_000
# It has no end of its own.
_NEVER_US = 2**53


class Display(NamedTuple):
    """A display as an admin sees it; ``used_us`` is 0 until it was first opened."""

    id: int
    name: str
    sites: tuple[str, ...]
    created_us: int
    used_us: int


class Displays:
    """Displays in the database; of a token the hash only."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` tells when each was used."""
        self._database = database
        self._clock = clock

    async def list_displays(self) -> list[Display]:
        """List them, the newest first."""
        columns = (displays.c[name] for name in Display._fields)
        async with self._database.read() as connection:
            rows = await connection.execute(select(*columns).order_by(displays.c.id.desc()))
            return [Display(*row)._replace(sites=tuple(json.loads(row.sites))) for row in rows]

    async def add_display(self, name: str, sites: Sequence[str]) -> tuple[int, str] | None:
        """Make one; give its number and its token, which is never shown again.

        Returns:
            None when there are as many as may be.

        """
        text = DISPLAY_MARK + new_token()
        async with self._database.write() as connection:
            count = await connection.execute(select(func.count()).select_from(displays))
            if count.scalar_one() >= MOST_DISPLAYS:
                return None
            added = await connection.execute(
                insert(displays).values(
                    name=name,
                    token_hash=hash_token(text),
                    sites=json.dumps(sorted(set(sites))),
                    created_us=self._now_us(),
                    used_us=0,
                )
            )
            key = added.inserted_primary_key
        return int(key[0]) if key else 0, text

    async def revoke_display(self, number: int) -> str | None:
        """Revoke one; give the name it had, None when there is none such."""
        async with self._database.write() as connection:
            found = await connection.execute(select(displays.c.name).where(displays.c.id == number))
            name = found.scalar()
            await connection.execute(delete(displays).where(displays.c.id == number))
        return name

    async def find_session(self, text: str) -> LiveSession | None:
        """Tell which display a token is of; None when it is unknown or revoked."""
        key = _NAMED + hash_token(text)
        found = (await self.live_sessions([key])).get(key)
        if found is not None and found.used_us < self._now_us() - _TOUCH_US:
            async with self._database.write() as connection:
                await connection.execute(
                    update(displays)
                    .where(displays.c.token_hash == key.removeprefix(_NAMED))
                    .values(used_us=self._now_us())
                )
        return found

    async def live_sessions(self, keys: Collection[str]) -> dict[str, LiveSession]:
        """Give those of the displays that are not revoked."""
        hashes = [key.removeprefix(_NAMED) for key in keys if key.startswith(_NAMED)]
        if not hashes:
            return {}
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(displays).where(displays.c.token_hash.in_(hashes))
            )
            return {
                _NAMED + row.token_hash: LiveSession(
                    Who(
                        _NAMED + row.token_hash,
                        # No person has such a number: what is counted by person counts each apart.
                        -row.id,
                        row.name,
                        "display",
                        Grants(
                            frozenset(
                                Permission(Right.VIEW, site) for site in json.loads(row.sites)
                            )
                        ),
                        script=True,
                        display=True,
                    ),
                    _NEVER_US,
                    _NEVER_US,
                    row.used_us,
                )
                for row in rows
            }

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000
