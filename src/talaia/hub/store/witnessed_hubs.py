"""Signed heads of other hubs' audit logs, kept here where those hubs cannot write over them.

Each other hub has a token of its own, which opens nothing else. Its key is the one that came with
its first heads: from then on only what that key has signed is kept, and all of it, also what
contradicts what was said before.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import delete, func, insert, select, update

from talaia.hub.auth.audit_heads import key_name, read_head
from talaia.hub.auth.tokens import TOKEN_MARK, hash_token, new_token
from talaia.hub.errors import HeadsRefused
from talaia.hub.store.witness_tables import witnessed_heads, witnessed_hubs

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence

    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.clock import Clock
    from talaia.hub.auth.audit_heads import AuditHead
    from talaia.hub.store.database import Database

__all__ = ["MOST_HUBS", "WITNESS_MARK", "WitnessedHub", "WitnessedHubs"]

# Begins as all tokens do, so that logs are masked of it, and opens nothing where those do.
WITNESS_MARK = f"{TOKEN_MARK}heads_"
MOST_HUBS = 100
# Of one hub: eleven years of heads. None gives way to a newer one before its time: whoever has
# that hub could else sign so many that the old ones went.
_MOST_HEADS = 100_000
_DAY_US = 86_400_000_000
_PAGE = 1000


class WitnessedHub(NamedTuple):
    """Another hub as an admin sees it. Times in µs (UTC), 0: never.

    Attributes:
        key: the short name of its key; empty until its first heads came.
        keep_days: so long a head is kept.
        heard_us: when it last sent anything.
        heads: how many are kept.
        row: the newest row that it has named; 0: none.
        time_us: when that row was its newest, by its own clock.
        problem: what does not fit together; empty while all does.

    """

    id: int
    name: str
    key: str
    keep_days: int
    created_us: int
    heard_us: int
    heads: int
    row: int
    time_us: int
    problem: str


class WitnessedHubs:
    """Adds and removes other hubs, and keeps what they send."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` tells when a head came, whatever it says itself."""
        self._database = database
        self._clock = clock

    async def list_hubs(self) -> list[WitnessedHub]:
        """List them, the newest first."""
        heads = witnessed_heads.c
        counted = (
            select(heads.hub_id, func.count().label("heads"), func.max(heads.id).label("last"))
            .group_by(heads.hub_id)
            .subquery()
        )
        asked = (
            select(witnessed_hubs, counted.c.heads, heads.row_id, heads.time_us)
            .join(counted, counted.c.hub_id == witnessed_hubs.c.id, isouter=True)
            .join(witnessed_heads, heads.id == counted.c.last, isouter=True)
            .order_by(witnessed_hubs.c.id.desc())
        )
        async with self._database.read() as connection:
            return [
                WitnessedHub(
                    row.id,
                    row.name,
                    key_name(row.public_key) if row.public_key else "",
                    row.keep_days,
                    row.created_us,
                    row.heard_us,
                    row.heads or 0,
                    row.row_id or 0,
                    row.time_us or 0,
                    row.problem,
                )
                for row in await connection.execute(asked)
            ]

    async def add_hub(self, name: str, keep_days: int) -> tuple[int, str] | None:
        """Make one; give its number and its token, which is never shown again.

        Returns:
            None when there are as many as may be.

        """
        text = WITNESS_MARK + new_token()
        async with self._database.write() as connection:
            count = await connection.execute(select(func.count()).select_from(witnessed_hubs))
            if count.scalar_one() >= MOST_HUBS:
                return None
            added = await connection.execute(
                insert(witnessed_hubs).values(
                    name=name,
                    token_hash=hash_token(text),
                    public_key="",
                    keep_days=keep_days,
                    created_us=self._now_us(),
                    heard_us=0,
                    problem="",
                )
            )
            key = added.inserted_primary_key
        return int(key[0]) if key else 0, text

    async def remove_hub(self, number: int) -> str | None:
        """Remove one with its heads; give the name it had, None when there is none such."""
        async with self._database.write() as connection:
            mine = witnessed_hubs.c.id == number
            name = (await connection.execute(select(witnessed_hubs.c.name).where(mine))).scalar()
            # By hand, too: SQLite keeps to foreign keys only where each connection asks for it.
            await connection.execute(
                delete(witnessed_heads).where(witnessed_heads.c.hub_id == number)
            )
            await connection.execute(delete(witnessed_hubs).where(mine))
        return name

    async def find_hub(self, token: str) -> tuple[int, str] | None:
        """Give number and name of the hub that a token is of; None: it is of none."""
        async with self._database.read() as connection:
            found = await connection.execute(
                select(witnessed_hubs.c.id, witnessed_hubs.c.name).where(
                    witnessed_hubs.c.token_hash == hash_token(token)
                )
            )
            row = found.first()
        return (int(row.id), str(row.name)) if row else None

    async def keep_heads(self, number: int, public: str, lines: Sequence[str]) -> str:
        """Keep what a hub has sent; give what no longer fits together since, or an empty text.

        Lines that are there already are passed over, so that whoever is not sure sends them again.

        Raises:
            HeadsRefused: they are not of the key that the hub had before, or are no heads.

        """
        async with self._database.write() as connection:
            found = await connection.execute(
                select(witnessed_hubs).where(witnessed_hubs.c.id == number).with_for_update()
            )
            hub = found.first()
            if hub is None:
                raise HeadsRefused("this hub was removed", "ask its admin for another token")
            if hub.public_key not in {"", public}:
                raise HeadsRefused(
                    f"it signs with another key than before ({key_name(hub.public_key)})",
                    "if its data folder was made anew, remove it here and add it again",
                )
            heads = [_read_line(line, public) for line in lines]
            now_us = self._now_us()
            await self._forget_old(connection, number, now_us - hub.keep_days * _DAY_US)
            problem = ""
            for head, line in zip(heads, lines, strict=True):
                wrong = await self._keep_head(
                    connection, number, head, line=line.strip(), now_us=now_us
                )
                problem = problem or wrong
            values: dict[str, object] = {"public_key": public, "heard_us": now_us}
            if problem and not hub.problem:
                values["problem"] = problem
            changed = update(witnessed_hubs).where(witnessed_hubs.c.id == number)
            await connection.execute(changed.values(**values))
        return "" if hub.problem else problem

    async def mark_refused(self, number: int, problem: str) -> bool:
        """Keep why a hub's heads were refused; tell whether nothing was wrong with it before."""
        async with self._database.write() as connection:
            marked = await connection.execute(
                update(witnessed_hubs)
                .where(witnessed_hubs.c.id == number, witnessed_hubs.c.problem == "")
                .values(problem=problem)
            )
        return bool(marked.rowcount)

    async def iterate_lines(self, number: int) -> AsyncIterator[str]:
        """Go through a hub's heads, the oldest first, as it has signed them."""
        last = 0
        while True:
            async with self._database.read() as connection:
                rows = await connection.execute(
                    select(witnessed_heads.c.id, witnessed_heads.c.line)
                    .where(witnessed_heads.c.hub_id == number, witnessed_heads.c.id > last)
                    .order_by(witnessed_heads.c.id)
                    .limit(_PAGE)
                )
                found = rows.all()
            if not found:
                return
            for row in found:
                yield str(row.line)
            last = int(found[-1].id)

    async def _forget_old(self, connection: AsyncConnection, number: int, before_us: int) -> None:
        # The newest stays: a hub that has been silent for as long is still held to it.
        newest = select(func.max(witnessed_heads.c.id)).where(witnessed_heads.c.hub_id == number)
        last = (await connection.execute(newest)).scalar()
        await connection.execute(
            delete(witnessed_heads).where(
                witnessed_heads.c.hub_id == number,
                witnessed_heads.c.received_us < before_us,
                witnessed_heads.c.id != (last or 0),
            )
        )

    async def _keep_head(
        self,
        connection: AsyncConnection,
        number: int,
        head: AuditHead,
        *,
        line: str,
        now_us: int,
    ) -> str:
        """Keep one; say what does not fit together by it."""
        mine = witnessed_heads.c.hub_id == number
        same = await connection.execute(
            select(witnessed_heads.c.hash).where(mine, witnessed_heads.c.row_id == head.row)
        )
        known = {str(row.hash) for row in same}
        if head.hash in known:
            return ""
        count = select(func.count(), func.max(witnessed_heads.c.row_id)).where(mine)
        kept, furthest = (await connection.execute(count)).one()
        if kept >= _MOST_HEADS:
            return f"{_MOST_HEADS} heads are kept already, and newer ones are not"
        await connection.execute(
            insert(witnessed_heads).values(
                hub_id=number,
                row_id=head.row,
                hash=head.hash,
                time_us=head.time_us,
                received_us=now_us,
                line=line,
            )
        )
        if known:
            return f"two heads say different things of row {head.row}: its log was made anew"
        if head.row < (furthest or 0):
            return (
                f"after row {furthest} it named row {head.row}: its log was cut off, or a backup"
                " was restored"
            )
        return ""

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000


def _read_line(line: str, public: str) -> AuditHead:
    try:
        head = read_head(line, public)
    except ValueError as error:
        raise HeadsRefused(str(error), "send the lines of audit-heads.log as they are") from error
    if head is None or not 0 < head.row < 2**62 or not 0 <= head.time_us < 2**62:
        raise HeadsRefused("a line is no head of this key", "send the lines of audit-heads.log")
    if len(head.hash) != 64 or not set(head.hash) <= set("0123456789abcdef"):
        raise HeadsRefused("a head names no hash", "send the lines of audit-heads.log")
    return head
