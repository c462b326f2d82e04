"""Messages to a person about their own account, by every way that they have chosen for alarms."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import insert, select

from talaia.hub.alarms.state_machine import What
from talaia.hub.store.alarm_tables import notices, notify_rules
from talaia.hub.store.alarms.notification_outbox import NoticeState
from talaia.hub.store.safe_text import safe_text
from talaia.model.alarms.alarm import Severity

if TYPE_CHECKING:
    from sqlalchemy.ext.asyncio import AsyncConnection

__all__ = ["add_account_notice"]

# Numbered by their time, below those of alarms (1, 2, …), requests and nights (-10**17 and below).
_FIRST = -(10**18)


async def add_account_notice(
    connection: AsyncConnection, user: int, *, title: str, text: str, now_us: int
) -> bool:
    """Put it into the outbox, once for each way and address; tell whether there is any.

    Quiet hours do not hold it back: somebody may be at the account now.
    """
    rows = await connection.execute(
        select(notify_rules.c.id, notify_rules.c.way, notify_rules.c.target)
        .where(notify_rules.c.user_id == user)
        .order_by(notify_rules.c.id)
    )
    # Several rules may lead to the same address.
    by_way = {(row.way, row.target): row.id for row in rows}
    told = [
        {
            "happened": _FIRST - now_us,
            "rule": rule,
            "user_id": user,
            "way": way,
            # About no site, alarm or device, so no right is asked when it goes out.
            "site": "",
            "alarm": "",
            "device": "",
            "episode": 0,
            "what": What.COMMENTED.value,
            "severity": Severity.WARNING.value,
            "title": safe_text(title, 200),
            "text": safe_text(text, 1000),
            "time_us": now_us,
            "state": NoticeState.PENDING.value,
            "parcel": "",
            "tries": 0,
            "due_us": now_us,
            "done_us": 0,
            "problem": "",
        }
        for (way, _), rule in by_way.items()
    ]
    if told:
        await connection.execute(insert(notices), told)
    return bool(told)
