"""Lines of robots' own logs: each kept once, found by time, level, node and words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import and_, delete, func, insert, or_, select, update

from talaia.hub.store.history_servers.own_rows import every_row
from talaia.hub.store.robot_log_tables import robot_log, robot_log_runs

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy import ColumnElement, Row

    from talaia.clock import Clock
    from talaia.hub.store.database import Database
    from talaia.hub.store.history_servers.own_rows import OwnRows

__all__ = ["KeptLogLine", "LogFilter", "LogPage", "LogPlace", "RobotLogStore", "StoredLine"]

# Lines that one question looks through for words: what it costs is bounded.
MOST_SEARCHED = 100_000
# Rows that are deleted in one transaction.
_AT_ONCE = 500
# Runs of gateways are known so much longer than their lines: what was kept at a gateway for long
# must not come twice.
_RUN_DAYS = 400
_DAY_US = 86_400_000_000


class StoredLine(NamedTuple):
    """A line as it is to be kept; see `talaia.wire.frames.LogLine`."""

    time_us: int
    level: int
    node: str
    text: str
    function: str
    file: str
    line: int
    left_out: int


class KeptLogLine(NamedTuple):
    """A line that is kept."""

    id: int
    body: StoredLine


class LogPlace(NamedTuple):
    """Where a page ends: that line, or what stands behind the last one that was looked at."""

    time_us: int
    id: int


class LogPage(NamedTuple):
    """Lines, the newest first; ``after``: where the next page goes on, none at the end."""

    lines: list[KeptLogLine]
    after: LogPlace | None


@dataclass(frozen=True, slots=True, kw_only=True)
class LogFilter:
    """Which lines are meant; what is empty does not matter.

    Lines that stand for what was left out are of every level and node.

    Attributes:
        from_us, to_us: said from the one to the other, both included.
        level: from this one on.
        node: only of this node.
        text: each of its words stands in the line or its node's name, in any case.
        before: only what stands behind this place in the list.

    """

    from_us: int = 0
    to_us: int = 2**53
    level: int = 0
    node: str = ""
    text: str = ""
    before: LogPlace | None = None


class RobotLogStore:
    """Rows of lines."""

    def __init__(
        self,
        database: Database,
        clock: Clock,
        *,
        most_searched: int = MOST_SEARCHED,
        own: OwnRows = every_row,
    ) -> None:
        """Work on ``database``; ``clock`` says what is old.

        A search looks through ``most_searched`` lines at a time. Only lines of ``own`` sites
        grow old here.
        """
        self._database, self._clock, self._own = database, clock, own
        self._most_searched = most_searched

    async def store_lines(
        self, site: str, boot: str, first: int, lines: Sequence[StoredLine]
    ) -> int:
        """Keep those lines of a run that are not kept yet; give how many that were."""
        run = and_(robot_log_runs.c.site == site, robot_log_runs.c.boot == boot)
        below, now_us = first + len(lines), self._clock.wall_ns() // 1000
        async with self._database.write() as connection:
            known = (await connection.execute(select(robot_log_runs.c.below).where(run))).scalar()
            fresh = lines[max(0, (known or 0) - first) :]
            if not fresh:
                return 0
            await connection.execute(
                insert(robot_log), [{"site": site, **line._asdict()} for line in fresh]
            )
            if known is None:
                row = {"site": site, "boot": boot, "below": below, "changed_us": now_us}
                await connection.execute(insert(robot_log_runs).values(**row))
            else:
                row = {"below": below, "changed_us": now_us}
                await connection.execute(update(robot_log_runs).where(run).values(**row))
        return len(fresh)

    async def find_lines(self, site: str, wanted: LogFilter, limit: int) -> LogPage:
        """List those that are meant, the newest first."""
        column = robot_log.c
        said = _conditions(site, wanted)
        words = [_has_word(word) for word in wanted.text.lower().split()]
        newest = (column.time_us.desc(), column.id.desc())
        query = select(robot_log).where(*said).order_by(*newest)
        if words:
            # Words are in no index: so many lines are looked at, and the next page goes on.
            searched = query.limit(self._most_searched).subquery()
            inner = robot_log.alias("found")
            query = (
                select(inner)
                .join(searched, inner.c.id == searched.c.id)
                .where(*(_has_word(word, inner.c) for word in wanted.text.lower().split()))
                .order_by(inner.c.time_us.desc(), inner.c.id.desc())
            )
        async with self._database.read() as connection:
            rows = (await connection.execute(query.limit(limit + 1))).all()
            found = [_line_of(row) for row in rows[:limit]]
            if len(rows) > limit:
                return LogPage(found, LogPlace(found[-1].body.time_us, found[-1].id))
            after = None
            if words:
                last = (
                    await connection.execute(
                        select(column.time_us, column.id)
                        .where(*said)
                        .order_by(*newest)
                        .offset(self._most_searched - 1)
                        .limit(1)
                    )
                ).first()
                after = None if last is None else LogPlace(last.time_us, last.id)
        return LogPage(found, after)

    async def list_nodes(self, site: str) -> list[str]:
        """List who said something that is kept."""
        column = robot_log.c
        query = (
            select(column.node)
            .where(column.site == site, column.node != "")
            .distinct()
            .order_by(column.node)
            .limit(1000)
        )
        return list(await self._database.fetch_scalars(query))

    async def delete_old(self, before_us: int, most: int) -> int:
        """Forget what was said before a time, and what is more than ``most`` of an own site.

        Gives how many lines went.
        """
        column, gone = robot_log.c, 0
        async with self._database.read() as connection:
            counted = await connection.execute(
                select(column.site, func.count())
                .where(*self._own(column.site))
                .group_by(column.site)
            )
            counts = [(str(site), int(count)) for site, count in counted.all()]
        for site, count in counts:
            old = select(func.count()).where(column.site == site, column.time_us < before_us)
            async with self._database.read() as connection:
                aged = int((await connection.execute(old)).scalar_one())
            gone += await self._delete_oldest(site, max(aged, count - most))
        known_us = self._clock.wall_ns() // 1000 - _RUN_DAYS * _DAY_US
        async with self._database.write() as connection:
            await connection.execute(
                delete(robot_log_runs).where(
                    robot_log_runs.c.changed_us < known_us, *self._own(robot_log_runs.c.site)
                )
            )
        return gone

    async def _delete_oldest(self, site: str, count: int) -> int:
        column, gone = robot_log.c, 0
        while gone < count:
            # Some at a time: nobody else writes meanwhile.
            async with self._database.write() as connection:
                oldest = await connection.execute(
                    select(column.id)
                    .where(column.site == site)
                    .order_by(column.time_us, column.id)
                    .limit(min(_AT_ONCE, count - gone))
                )
                numbers = [row.id for row in oldest]
                await connection.execute(delete(robot_log).where(column.id.in_(numbers)))
            gone += len(numbers)
            if not numbers:
                break
        return gone


def _conditions(site: str, wanted: LogFilter) -> list[ColumnElement[bool]]:
    column = robot_log.c
    said = [
        column.site == site,
        column.time_us >= wanted.from_us,
        column.time_us <= wanted.to_us,
    ]
    if wanted.level:
        said.append(or_(column.level >= wanted.level, column.left_out > 0))
    if wanted.node:
        said.append(or_(column.node == wanted.node, column.left_out > 0))
    if wanted.before is not None:
        time_us, number = wanted.before
        same = and_(column.time_us == time_us, column.id < number)
        said.append(or_(column.time_us < time_us, same))
    return said


def _has_word(word: str, column: Any = robot_log.c) -> ColumnElement[bool]:  # noqa: ANN401
    # What people type holds no wildcards: `%` and `_` stand for themselves.
    return or_(
        *(func.lower(text).contains(word, autoescape=True) for text in (column.text, column.node))
    )


def _line_of(row: Row[Any]) -> KeptLogLine:
    return KeptLogLine(row.id, StoredLine(*(getattr(row, name) for name in StoredLine._fields)))
