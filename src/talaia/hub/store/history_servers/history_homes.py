"""Which server has the history of which site, and which move is under way; with the accounts."""

from __future__ import annotations

import secrets
from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import func, insert, select, update

from talaia.hub.store.history_servers.home_tables import history_homes, history_term

if TYPE_CHECKING:
    from sqlalchemy.engine import Row
    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.hub.store.database import Database

__all__ = ["HistoryHome", "HistoryHomes"]

_ROW = 1
_home = history_homes


class HistoryHome(NamedTuple):
    """Where a site's history is.

    Attributes:
        moving_to: where it moves; empty: it stays.
        move: tells this move from any other.
        erase_at: where what was left behind is still to be erased; empty: nowhere.
        done_blocks: of ``all_blocks`` have been copied.
        problem: what the move waits for, in words; empty: it goes on.
        hold: what the leads of two shards say to each other about a move between them; see
            `talaia.hub.store.history_servers.shard_handover`.
        led_by: the server whose shard leads the site though it has moved; empty: that of
            ``server``; `NOBODY`: it has let go.
        turn: rises over all sites whenever one changes its server.

    """

    site: str
    server: str
    moving_to: str
    move: str
    erase_at: str
    done_blocks: int
    all_blocks: int
    problem: str
    hold: str = ""
    led_by: str = ""
    turn: int = 0


class HistoryHomes:
    """One row for each site whose history has ever been asked to be elsewhere."""

    def __init__(self, database: Database) -> None:
        """Use the accounts' database."""
        self._database = database

    async def list_homes(self) -> list[HistoryHome]:
        """List all that have a row.

        Raises:
            StoreDown: the database does not answer.

        """
        async with self._database.read() as connection:
            rows = (await connection.execute(select(_home).order_by(_home.c.site))).all()
        return [_read_home(row) for row in rows]

    async def find_home(self, site: str) -> HistoryHome | None:
        """Find a site's row.

        Raises:
            StoreDown: the database does not answer.

        """
        async with self._database.read() as connection:
            return await _find_home(connection, site)

    async def add_home(self, site: str, server: str) -> HistoryHome:
        """Write down where a new site's history is, unless that is written; give what stands.

        Raises:
            StoreDown: the database does not answer.

        """
        async with self._database.write() as connection:
            found = await _find_home(connection, site)
            if found is None:
                found = HistoryHome(site, server, "", "", "", 0, 0, "")
                await connection.execute(insert(_home), found._asdict())
        return found

    async def ask_move(self, site: str, server: str, *, own: str) -> HistoryHome:
        """Ask that a site's history move to ``server``; the hub does it. Give what stands then.

        To ask for where it is ends a move that is under way. ``own``: where a site without a row
        is.

        Raises:
            StoreDown: the database does not answer.

        """
        async with self._database.write() as connection:
            found = await _find_home(connection, site)
            if found is None:
                found = HistoryHome(site, own, "", "", "", 0, 0, "")
                await connection.execute(insert(_home), found._asdict())
            # Asked twice is asked once: what was copied stays.
            if found.moving_to == server:
                return found
            if server == found.server:
                # What has come to the other place goes; nothing has while an older rest is there.
                erase_at = found.erase_at or found.moving_to
                asked = found._replace(
                    moving_to="", move="", erase_at=erase_at, problem="", hold=""
                )
            else:
                asked = found._replace(
                    moving_to=server,
                    move=secrets.token_hex(8),
                    done_blocks=0,
                    all_blocks=0,
                    problem="",
                    hold="",
                )
            await connection.execute(
                update(_home).where(_home.c.site == site).values(**asked._asdict())
            )
        return asked

    async def report_progress(self, home: HistoryHome) -> None:
        """Write down how far a move is, for who looks.

        Raises:
            StoreDown: the database does not answer.

        """
        said = {
            "done_blocks": home.done_blocks,
            "all_blocks": home.all_blocks,
            "problem": home.problem[:1000],
        }
        async with self._database.write() as connection:
            await connection.execute(
                update(_home)
                .where(_home.c.site == home.site, _home.c.move == home.move)
                .values(**said)
            )

    async def switch_home(self, home: HistoryHome, *, led_by: str = "") -> bool:
        """Let a site's history be where it moves: this commit is the move.

        ``led_by``: the server whose shard leads the site on until it lets go. Then ``home.hold``
        has to be what stands there: either this or the end of the hold happens.

        Returns:
            False when it was asked for otherwise meanwhile.

        Raises:
            StoreDown: it is not known whether it is done.

        """
        held = (_home.c.hold == home.hold,) if led_by else ()
        moved = {"server": home.moving_to, "erase_at": home.server, "led_by": led_by}
        async with self._database.write() as connection:
            turn = int(await connection.scalar(select(func.max(_home.c.turn))) or 0) + 1
            result = await connection.execute(
                update(_home)
                .where(_home.c.site == home.site, _home.c.move == home.move)
                .where(_home.c.server == home.server, _home.c.moving_to == home.moving_to, *held)
                .values(moving_to="", move="", hold="", problem="", turn=turn, **moved)
            )
        return result.rowcount == 1

    async def finish_erasing(self, site: str, server: str) -> None:
        """Write down that nothing is left at ``server``.

        Raises:
            StoreDown: the database does not answer.

        """
        async with self._database.write() as connection:
            await connection.execute(
                update(_home)
                .where(_home.c.site == site, _home.c.erase_at == server)
                .values(erase_at="")
            )

    async def own_name(self) -> str:
        """Give the name under which this hub's histories are known on other servers.

        Raises:
            StoreDown: the database does not answer.

        """
        async with self._database.write() as connection:
            return (await _read_term(connection))[0]

    async def raise_term(self, seen: int) -> int:
        """Give a term that is higher than ``seen`` and than any before.

        Raises:
            StoreDown: the database does not answer, or another hub leads.

        """
        async with self._database.write() as connection:
            _, known = await _read_term(connection)
            term = max(known, seen) + 1
            await connection.execute(
                update(history_term).where(history_term.c.id == _ROW).values(term=term)
            )
        return term


def _read_home(row: Row[Any]) -> HistoryHome:
    return HistoryHome._make(row)


async def _find_home(connection: AsyncConnection, site: str) -> HistoryHome | None:
    row = (await connection.execute(select(_home).where(_home.c.site == site))).one_or_none()
    return None if row is None else _read_home(row)


async def _read_term(connection: AsyncConnection) -> tuple[str, int]:
    row = (await connection.execute(select(history_term.c.hub, history_term.c.term))).one_or_none()
    if row is not None:
        return row.hub, int(row.term)
    name = secrets.token_hex(16)
    await connection.execute(insert(history_term), {"id": _ROW, "hub": name, "term": 0})
    return name, 0
