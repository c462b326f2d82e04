"""The outbox: what people are to be told, and what became of it.

A row goes ``pending`` → ``sending`` → ``sent``, ``failed`` or ``unsure``; one that certainly did
not arrive goes back to ``pending`` for another try. ``sending`` is written before a word leaves
the hub. So a row that is found in it at the start may have been delivered, and is not sent again
unless the way lets the other side see that it is the same message (decision 0050).

Long, because a row's whole life is told here, from what happened to what became of it.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import and_, func, insert, or_, select, true, update

from talaia.hub.alarms.rules import Rule, due_us, rule_matches
from talaia.hub.alarms.state_machine import What
from talaia.hub.auth.permissions import ANY, Right
from talaia.hub.auth.tokens import new_token
from talaia.hub.store.accounts.permission_grants import OF_ROLES, grants_of
from talaia.hub.store.alarm_tables import notices, notify_rules
from talaia.hub.store.safe_text import safe_text
from talaia.hub.store.tables import users
from talaia.model.alarms.alarm import Severity

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.hub.alarms.state_machine import Happened
    from talaia.hub.store.database import Database

__all__ = [
    "About",
    "NoticeState",
    "NotificationOutbox",
    "OutboxMessage",
    "OutboxNotice",
    "add_notices",
    "rule_of",
]

# What one message tells at the most.
_AT_ONCE = 50
# Characters of a message's key.
_PARCEL = 32


class NoticeState(StrEnum):
    """Where a notice stands."""

    PENDING = "pending"
    SENDING = "sending"
    SENT = "sent"
    # It certainly did not arrive, and is not tried again.
    FAILED = "failed"
    # It may have arrived: the hub ended, or the line broke, while it was under way.
    UNSURE = "unsure"
    # Nobody is there any more who may be told.
    DROPPED = "dropped"


# Of a notice with a problem: what went wrong, may have, or is tried again.
_FAILED_STATES = tuple(
    state.value for state in (NoticeState.FAILED, NoticeState.UNSURE, NoticeState.PENDING)
)


class About(NamedTuple):
    """What a notice says of the alarm itself."""

    site: str
    alarm: str
    device: str
    severity: Severity
    name: str
    site_name: str
    advice: str


class OutboxNotice(NamedTuple):
    """One line of a message."""

    id: int
    site: str
    alarm: str
    what: What
    severity: Severity
    title: str
    text: str
    time_us: int
    device: str = ""


class OutboxMessage(NamedTuple):
    """What goes out as one message, by one rule.

    Attributes:
        key: names it; the same when it is sent again.
        zone: the person's, for the times in it.
        tries: how often it was tried, this time included.

    """

    key: str
    rule: int
    user: int
    way: int
    target: str
    zone: str
    tries: int
    notices: tuple[OutboxNotice, ...]


async def add_notices(
    connection: AsyncConnection, about: About, *, happened_id: int, happened: Happened, now_us: int
) -> None:
    """Put what happened into the outbox of everybody who wants to know it and may."""
    rows = await connection.execute(
        select(notify_rules, users.c.role_id)
        .join(users, users.c.id == notify_rules.c.user_id)
        .where(notify_rules.c.site.in_((ANY, about.site)), users.c.disabled.is_(False))
        .where(users.c.name.in_(happened.to) if happened.to else true())
    )
    wanted = [
        (rule, row.role_id)
        for row in rows
        if rule_matches(rule := rule_of(row), about.site, about.severity, happened)
    ]
    if not wanted:
        return
    grants = await grants_of(connection, OF_ROLES, {role for _, role in wanted})
    told = []
    for rule, role in wanted:
        # A rule gives no right: who may not view it is not told.
        if not grants[role].has_right(Right.VIEW, about.site, about.device or ANY):
            continue
        due = due_us(rule, about.severity, now_us)
        told.append(
            {
                "happened": happened_id,
                "rule": rule.id,
                "user_id": rule.user,
                "way": rule.way,
                "site": about.site,
                "alarm": about.alarm,
                "device": about.device,
                "episode": happened.episode,
                "what": happened.what.value,
                "severity": about.severity.value,
                "title": safe_text(f"{about.site_name}: {about.name}", 200),
                "text": _notice_text(about, happened),
                "time_us": happened.time_us,
                "state": NoticeState.PENDING.value,
                "parcel": "",
                "tries": 0,
                "due_us": await _with_the_others(connection, rule, now_us, due),
                "done_us": 0,
                "problem": "",
            }
        )
    if told:
        await connection.execute(insert(notices), told)


def rule_of(row: object) -> Rule:
    """Read a row of rules."""
    found = row._mapping  # type: ignore[attr-defined]  # noqa: SLF001 - SQLAlchemy's own name
    return Rule(
        id=found["id"],
        user=found["user_id"],
        site=found["site"],
        way=found["way"],
        target=found["target"],
        least=Severity(found["least"]),
        over=found["over"],
        quiet_from=found["quiet_from"],
        quiet_to=found["quiet_to"],
        quiet_least=Severity(found["quiet_least"]),
        zone=found["zone"],
        group_s=found["group_s"],
        own_requests=bool(found["own_requests"]),
        nights=bool(found["nights"]),
    )


def _notice_text(about: About, happened: Happened) -> str:
    said = safe_text(happened.message, 1000)
    advice = safe_text(about.advice, 1000) if happened.what is not What.CLEARED else ""
    return f"{said}\n{advice}".strip()


async def _with_the_others(connection: AsyncConnection, rule: Rule, now_us: int, due: int) -> int:
    """Go out with what waits already: a burst is one message, counted from its first."""
    if due > now_us + rule.group_s * 1_000_000:
        # It waits for the end of quiet hours, also when something worse goes out in them.
        return due
    found = await connection.execute(
        select(func.min(notices.c.due_us)).where(
            notices.c.rule == rule.id,
            notices.c.state == NoticeState.PENDING.value,
            # Not with one that is tried again: that waits for a time of its own.
            notices.c.tries == 0,
            notices.c.due_us > now_us,
        )
    )
    first = found.scalar()
    return due if first is None else min(due, int(first))


class NotificationOutbox:
    """The outbox, as whoever delivers sees it."""

    def __init__(self, database: Database) -> None:
        """Work on ``database``."""
        self._database = database

    async def next_due_us(self) -> int | None:
        """Give when the next one may go out; None when nothing waits."""
        async with self._database.read() as connection:
            found = await connection.execute(
                select(func.min(notices.c.due_us)).where(
                    notices.c.state == NoticeState.PENDING.value
                )
            )
            due = found.scalar()
        return None if due is None else int(due)

    async def claim_due(self, now_us: int) -> OutboxMessage | None:
        """Take what is due by one rule as one message; from now on it is ``sending``.

        What was part of a message before (it is sent once more) keeps its key and goes alone, by
        the way that it went: it may have arrived there. All else goes by the way that its rule
        names by now, which is not always that of the moment when it happened.
        """
        pending = notices.c.state == NoticeState.PENDING.value
        async with self._database.write() as connection:
            found = await connection.execute(
                select(notices.c.rule, notices.c.parcel)
                .where(pending, notices.c.due_us <= now_us)
                .order_by(notices.c.due_us, notices.c.id)
                .limit(1)
            )
            first = found.first()
            if first is None:
                return None
            rows = (
                await connection.execute(
                    select(notices)
                    .where(
                        pending,
                        notices.c.rule == first.rule,
                        notices.c.parcel == first.parcel,
                        or_(notices.c.due_us <= now_us, notices.c.parcel != ""),
                    )
                    .order_by(notices.c.id)
                    .limit(_AT_ONCE)
                )
            ).all()
            key = first.parcel or new_token()[:_PARCEL]
            ids = [row.id for row in rows]
            found_target = await self._find_target(connection, rows[0])
            if found_target is None:
                await self._mark_notices(
                    connection, ids, state=NoticeState.DROPPED, now_us=now_us, problem=""
                )
                return OutboxMessage(key, first.rule, 0, 0, "", "UTC", 0, ())
            rule_way, target, zone = found_target
            way = rows[0].way if first.parcel else rule_way
            await connection.execute(
                update(notices)
                .where(notices.c.id.in_(ids))
                .values(
                    state=NoticeState.SENDING.value,
                    way=way,
                    parcel=key,
                    tries=notices.c.tries + 1,
                )
            )
        told = tuple(_row_to_notice(row) for row in rows)
        tries = max(row.tries for row in rows) + 1
        return OutboxMessage(key, first.rule, rows[0].user_id, way, target, zone, tries, told)

    async def mark_sent(self, parcel: OutboxMessage, now_us: int) -> None:
        """It has arrived."""
        await self._settle_notices(parcel, NoticeState.SENT, now_us, "")

    async def mark_failed(self, parcel: OutboxMessage, now_us: int, problem: str) -> None:
        """It has not arrived, and is not tried again."""
        await self._settle_notices(parcel, NoticeState.FAILED, now_us, problem)

    async def mark_unsure(self, parcel: OutboxMessage, now_us: int, problem: str) -> None:
        """It may have arrived."""
        await self._settle_notices(parcel, NoticeState.UNSURE, now_us, problem)

    async def retry_later(
        self, parcel: OutboxMessage, due: int, problem: str, *, same: bool
    ) -> None:
        """It is tried once more, later.

        Args:
            parcel: which.
            due: not before (µs, UTC).
            problem: what went wrong.
            same: it may have arrived: as the very same message, so that the other side can tell.

        """
        ids = [notice.id for notice in parcel.notices]
        values: dict[str, object] = {
            "state": NoticeState.PENDING.value,
            "due_us": due,
            "problem": safe_text(problem, 2000),
        }
        # Without a key it may go with others next time.
        if not same:
            values["parcel"] = ""
        async with self._database.write() as connection:
            await connection.execute(update(notices).where(notices.c.id.in_(ids)).values(**values))

    async def recover_unsent(self, repeatable: Collection[int], now_us: int) -> int:
        """See to what was under way when the hub ended; give how many are left unsure.

        By a way in ``repeatable`` it is sent once more, as the very same message.
        """
        sending = notices.c.state == NoticeState.SENDING.value
        why = "the hub ended while it was being sent: it may have been delivered"
        async with self._database.write() as connection:
            # First: what is left in `sending` after this is not sent again.
            await connection.execute(
                update(notices)
                .where(sending, notices.c.way.in_(list(repeatable)))
                .values(state=NoticeState.PENDING.value, due_us=now_us, problem=why)
            )
            done = await connection.execute(
                update(notices)
                .where(sending)
                .values(state=NoticeState.UNSURE.value, done_us=now_us, problem=why)
            )
        return done.rowcount

    async def trouble_mark(self) -> tuple[int, ...]:
        """Give numbers, of which one is another whenever a message fails or goes out after all."""
        column = notices.c
        query = select(
            func.count(),
            func.max(column.id),
            func.sum(column.tries),
            func.max(column.due_us),
            func.max(column.done_us),
        ).where(column.problem != "", column.state.in_(_FAILED_STATES))
        async with self._database.read() as connection:
            row = (await connection.execute(query)).one()
        return tuple(int(number or 0) for number in row)

    async def failed_alarms(self) -> dict[tuple[str, str], str]:
        """Name the alarms of whose latest episode a message failed, with the reason.

        What may have been delivered is among them, and what is being tried again.
        """
        latest = (
            select(notices.c.site, notices.c.alarm, func.max(notices.c.episode).label("episode"))
            .group_by(notices.c.site, notices.c.alarm)
            .subquery()
        )
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(notices.c.site, notices.c.alarm, notices.c.problem)
                .join(
                    latest,
                    and_(
                        latest.c.site == notices.c.site,
                        latest.c.alarm == notices.c.alarm,
                        latest.c.episode == notices.c.episode,
                    ),
                )
                .where(
                    notices.c.problem != "",
                    notices.c.state.in_(_FAILED_STATES),
                )
                .order_by(notices.c.id)
            )
            # In the order of their numbers, so the newest problem of an alarm stays.
            return {(row.site, row.alarm): row.problem for row in rows}

    @staticmethod
    async def _find_target(connection: AsyncConnection, row: object) -> tuple[int, str, str] | None:
        """Give the way, where to, and the zone; None when rule, person or right are gone."""
        found = row._mapping  # type: ignore[attr-defined]  # noqa: SLF001 - SQLAlchemy's own name
        rows = await connection.execute(
            select(notify_rules.c.way, notify_rules.c.target, notify_rules.c.zone, users.c.role_id)
            .join(users, users.c.id == notify_rules.c.user_id)
            .where(notify_rules.c.id == found["rule"], users.c.disabled.is_(False))
        )
        there = rows.first()
        if there is None:
            return None
        # About no alarm and nothing of the site: it is of a request of their own.
        if not found["alarm"] and not found["device"]:
            return int(there.way), str(there.target), str(there.zone)
        # Asked again: rights may have changed since it happened.
        grants = await grants_of(connection, OF_ROLES, {there.role_id})
        if not grants[there.role_id].has_right(Right.VIEW, found["site"], found["device"] or ANY):
            return None
        return int(there.way), str(there.target), str(there.zone)

    async def _settle_notices(
        self, parcel: OutboxMessage, state: NoticeState, now_us: int, problem: str
    ) -> None:
        ids = [notice.id for notice in parcel.notices]
        async with self._database.write() as connection:
            await self._mark_notices(connection, ids, state=state, now_us=now_us, problem=problem)

    @staticmethod
    async def _mark_notices(
        connection: AsyncConnection,
        ids: Sequence[int],
        *,
        state: NoticeState,
        now_us: int,
        problem: str,
    ) -> None:
        await connection.execute(
            update(notices)
            .where(notices.c.id.in_(list(ids)))
            .values(state=state.value, done_us=now_us, problem=safe_text(problem, 2000))
        )


def _row_to_notice(row: object) -> OutboxNotice:
    found = row._mapping  # type: ignore[attr-defined]  # noqa: SLF001 - SQLAlchemy's own name
    return OutboxNotice(
        found["id"],
        found["site"],
        found["alarm"],
        What(found["what"]),
        Severity(found["severity"]),
        found["title"],
        found["text"],
        found["time_us"],
        found["device"],
    )
