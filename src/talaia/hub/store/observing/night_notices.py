"""Messages about nights that run by themselves: one is over, or needs somebody.

They go to everybody who may view the site and has a rule of notification that asks for them, out of
the same outbox as messages about alarms.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import insert, select

from talaia.hub.alarms.rules import due_us
from talaia.hub.alarms.state_machine import What
from talaia.hub.auth.permissions import ANY, Right
from talaia.hub.store.accounts.permission_grants import OF_ROLES, grants_of
from talaia.hub.store.alarm_tables import notices, notify_rules
from talaia.hub.store.alarms.notification_outbox import NoticeState, rule_of
from talaia.hub.store.safe_text import safe_text
from talaia.hub.store.tables import users

if TYPE_CHECKING:
    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.model.alarms.alarm import Severity

__all__ = ["NightNotice", "add_night_notice"]

# Alarms count what happened upwards from 1, requests downwards by the lines of their logs: these
# are numbered by the time of the gateway, far below both.
_FIRST = -(10**17)


class NightNotice(NamedTuple):
    """What is told of a site's night.

    Attributes:
        title: what happened, in a few words.
        text: the gateway's own words.
        time_us: when, by the gateway (UTC).

    """

    site: str
    title: str
    text: str
    severity: Severity
    time_us: int


async def add_night_notice(connection: AsyncConnection, notice: NightNotice, now_us: int) -> bool:
    """Put it into the outbox of whoever wants to know and may; tell whether anybody does.

    What comes once more is not told once more.
    """
    happened = _FIRST - notice.time_us
    rows = await connection.execute(
        select(notify_rules, users.c.role_id)
        .join(users, users.c.id == notify_rules.c.user_id)
        .where(
            notify_rules.c.nights.is_(True),
            notify_rules.c.site.in_((ANY, notice.site)),
            users.c.disabled.is_(False),
        )
    )
    wanted = [(rule_of(row), row.role_id) for row in rows]
    grants = await grants_of(connection, OF_ROLES, {role for _, role in wanted})
    known = set(
        await connection.scalars(
            select(notices.c.rule).where(
                notices.c.happened == happened, notices.c.site == notice.site
            )
        )
    )
    told = [
        {
            "happened": happened,
            "rule": rule.id,
            "user_id": rule.user,
            "way": rule.way,
            "site": notice.site,
            # About no alarm, but about the whole site: rights are asked again when it goes out.
            "alarm": "",
            "device": ANY,
            "episode": 0,
            "what": What.COMMENTED.value,
            "severity": notice.severity.value,
            "title": safe_text(notice.title, 200),
            "text": safe_text(notice.text, 1000),
            "time_us": notice.time_us,
            "state": NoticeState.PENDING.value,
            "parcel": "",
            "tries": 0,
            "due_us": due_us(rule, notice.severity, now_us),
            "done_us": 0,
            "problem": "",
        }
        for rule, role in wanted
        if rule.id not in known and grants[role].has_right(Right.VIEW, notice.site, ANY)
    ]
    if told:
        await connection.execute(insert(notices), told)
    return bool(told)
