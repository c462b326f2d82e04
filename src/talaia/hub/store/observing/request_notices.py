"""Messages to whoever asked: a request is observed, or has ended without it.

They go by the person's own rules of notification, those that ask for it, and out of the same
outbox as messages about alarms, in the transaction in which the request has ended: one for each
end and rule, whatever happens to the hub.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import insert, select

from talaia.hub.alarms.rules import due_us
from talaia.hub.alarms.state_machine import What
from talaia.hub.auth.permissions import ANY
from talaia.hub.store.alarm_tables import notices, notify_rules
from talaia.hub.store.alarms.notification_outbox import NoticeState, rule_of
from talaia.hub.store.safe_text import safe_text
from talaia.hub.store.tables import users
from talaia.model.alarms.alarm import Severity
from talaia.model.observing.states import RequestState

if TYPE_CHECKING:
    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.hub.store.observing.request_rows import EndedRequest

__all__ = ["add_request_notices"]

# What a person did themselves they are not told.
_SAID = {
    RequestState.COMPLETED: ("is observed", Severity.INFO),
    RequestState.WINDOW_EXPIRED: ("was not observed in its windows", Severity.WARNING),
    RequestState.FAILURE_LIMIT_REACHED: ("has failed too often", Severity.WARNING),
}


async def add_request_notices(
    connection: AsyncConnection, ended: EndedRequest, now_us: int
) -> None:
    """Put the end of a request into the outbox of whoever asked, if they want to know it."""
    if ended.state not in _SAID:
        return
    said, severity = _SAID[ended.state]
    rows = await connection.execute(
        select(notify_rules)
        .join(users, users.c.id == notify_rules.c.user_id)
        .where(
            notify_rules.c.user_id == ended.user,
            notify_rules.c.own_requests.is_(True),
            notify_rules.c.site.in_((ANY, ended.site)),
            users.c.disabled.is_(False),
        )
    )
    name = ended.target or f"request {ended.id}"
    told = [
        {
            # Alarms count their own upwards from 1; these are the lines of requests' logs.
            "happened": -ended.log,
            "rule": rule.id,
            "user_id": rule.user,
            "way": rule.way,
            "site": ended.site,
            # About no alarm: what may be told of it is the person's own.
            "alarm": "",
            "device": "",
            "episode": 0,
            "what": What.COMMENTED.value,
            "severity": severity.value,
            "title": safe_text(f"{ended.site}: {name} {said}", 200),
            "text": safe_text(f"request {ended.id} of {ended.proposal}: {ended.why}", 1000),
            "time_us": now_us,
            "state": NoticeState.PENDING.value,
            "parcel": "",
            "tries": 0,
            "due_us": due_us(rule, severity, now_us),
            "done_us": 0,
            "problem": "",
        }
        for rule in map(rule_of, rows)
    ]
    if told:
        await connection.execute(insert(notices), told)
