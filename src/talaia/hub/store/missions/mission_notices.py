"""Messages about missions that failed, were interrupted or were missed.

They go to everybody who may view the site and has a rule of notification for it that takes such a
severity, out of the same outbox as messages about alarms.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import insert, select

from talaia.hub.alarms.rules import due_us
from talaia.hub.alarms.state_machine import What
from talaia.hub.auth.permissions import ANY, Right
from talaia.hub.store.accounts.permission_grants import OF_ROLES, grants_of
from talaia.hub.store.alarm_tables import notices, notify_rules
from talaia.hub.store.alarms.notification_outbox import NoticeState, rule_of
from talaia.hub.store.safe_text import safe_text
from talaia.hub.store.tables import users
from talaia.model.alarms.alarm import Severity

if TYPE_CHECKING:
    from talaia.hub.store.database import Database
    from talaia.hub.store.missions.mission_store import RunRecord

__all__ = ["add_mission_notice"]

# Alarms count what happened upwards, requests downwards, nights by their time far below: runs are
# numbered still below those.
_FIRST = -4 * 10**18


async def add_mission_notice(
    database: Database, record: RunRecord, site_name: str, now_us: int
) -> bool:
    """Put it into the outbox of whoever wants to know and may; tell whether anybody does.

    Raises:
        StoreDown: it is not in the outbox.

    """
    happened = _FIRST - record.id
    severity = Severity.WARNING
    async with database.write() as connection:
        rows = await connection.execute(
            select(notify_rules, users.c.role_id)
            .join(users, users.c.id == notify_rules.c.user_id)
            .where(notify_rules.c.site.in_((ANY, record.site)), users.c.disabled.is_(False))
        )
        wanted = [(rule_of(row), row.role_id) for row in rows]
        grants = await grants_of(connection, OF_ROLES, {role for _, role in wanted})
        known = set(
            await connection.scalars(select(notices.c.rule).where(notices.c.happened == happened))
        )
        told = [
            {
                "happened": happened,
                "rule": rule.id,
                "user_id": rule.user,
                "way": rule.way,
                "site": record.site,
                # About no alarm, but about the whole site: rights are asked again as it goes out.
                "alarm": "",
                "device": ANY,
                "episode": 0,
                "what": What.COMMENTED.value,
                "severity": severity.value,
                "title": safe_text(f"{site_name}: mission {record.name} {record.state}", 200),
                "text": safe_text(record.why, 1000),
                "time_us": now_us,
                "state": NoticeState.PENDING.value,
                "parcel": "",
                "tries": 0,
                "due_us": due_us(rule, severity, now_us),
                "done_us": 0,
                "problem": "",
            }
            for rule, role in wanted
            if rule.id not in known
            and severity.rank >= rule.least.rank
            and grants[role].has_right(Right.VIEW, record.site, ANY)
        ]
        if told:
            await connection.execute(insert(notices), told)
    return bool(told)
