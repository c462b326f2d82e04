"""Rows of alert rules, of notices that came, and of the requests that were made of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import msgspec
from sqlalchemy import delete, insert, or_, select, update

from talaia.hub.observing.alert_rules import AlertRule, event_key, notice_key
from talaia.hub.store.accounts.permission_grants import OF_ROLES, grants_of
from talaia.hub.store.alert_notice_tables import alert_notices, alert_outcomes, alert_rules
from talaia.hub.store.tables import users
from talaia.wire.alerts.notice import AlertNotice

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

    from sqlalchemy import ColumnElement
    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.clock import Clock
    from talaia.hub.auth.permissions import Grants
    from talaia.hub.store.database import Database

__all__ = ["AlertAsker", "AlertStore", "KeptNotice", "KeptRule"]

# Notices that are kept of each site: previews look at fewer.
MOST_NOTICES = 500


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptRule:
    """A rule as it is kept: whose it is, and in whose name it asks.

    Attributes:
        id: its number; 0: it is about to be written.
        site: whose nights it asks for.
        proposal: which pays.
        user: the account that made it or changed it last.
        rule: what it does.

    """

    site: str
    proposal: str
    user: int
    rule: AlertRule
    id: int = 0


class KeptNotice(NamedTuple):
    """A notice as it is kept; ``groups``: what was asked because of it, by rule."""

    id: int
    received_us: int
    notice: AlertNotice
    handled: bool
    groups: dict[int, int]


class AlertAsker(NamedTuple):
    """An account in whose name something is asked, with its rights as they are now."""

    user: int
    name: str
    grants: Grants


class AlertStore:
    """Rules, notices and outcomes of all sites."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` stamps what comes."""
        self._database = database
        self._clock = clock

    async def list_rules(self, site: str, proposal: str = "") -> list[KeptRule]:
        """List the rules of a site, or of one of its proposals, in the order of their making."""
        asked = select(alert_rules).where(alert_rules.c.site == site).order_by(alert_rules.c.id)
        if proposal:
            asked = asked.where(alert_rules.c.proposal == proposal)
        async with self._database.read() as connection:
            rows = (await connection.execute(asked)).all()
        return [
            KeptRule(
                id=row.id,
                site=row.site,
                proposal=row.proposal,
                user=row.user_id,
                rule=_RULE.decode(row.definition),
            )
            for row in rows
        ]

    async def write_rule(self, kept: KeptRule) -> int:
        """Add a rule, or write one anew; give its number; 0: there is none of that number."""
        values = {
            "user_id": kept.user,
            "definition": msgspec.json.encode(kept.rule).decode(),
            "changed_us": self._now_us(),
        }
        async with self._database.write() as connection:
            if kept.id:
                changed = await connection.execute(
                    update(alert_rules).where(*_is_rule(kept)).values(**values)
                )
                return kept.id if changed.rowcount == 1 else 0
            added = await connection.execute(
                insert(alert_rules).values(site=kept.site, proposal=kept.proposal, **values)
            )
        key = added.inserted_primary_key
        return int(key[0]) if key else 0

    async def remove_rule(self, site: str, proposal: str, number: int) -> bool:
        """Remove a rule; what it has asked for stays. False: there is none."""
        async with self._database.write() as connection:
            done = await connection.execute(
                delete(alert_rules).where(
                    alert_rules.c.site == site,
                    alert_rules.c.proposal == proposal,
                    alert_rules.c.id == number,
                )
            )
        return done.rowcount == 1

    async def keep_notice(self, site: str, notice: AlertNotice, user: int) -> KeptNotice:
        """Write a notice down unless it is there; give it as it is kept. The oldest go.

        ``user`` brought it; 0: the hub found it in its folder.
        """
        async with self._database.write() as connection:
            known = await _read_notices(
                connection,
                site,
                (
                    alert_notices.c.notice_key == notice_key(notice.id),
                    alert_notices.c.user_id == user,
                ),
                1,
            )
            if known:
                return known[0]
            now_us = self._now_us()
            added = await connection.execute(
                insert(alert_notices).values(
                    site=site,
                    user_id=user,
                    notice_key=notice_key(notice.id),
                    event_key=event_key(notice),
                    received_us=now_us,
                    handled_us=0,
                    definition=msgspec.json.encode(notice).decode(),
                )
            )
            key = added.inserted_primary_key
            number = int(key[0]) if key else 0
            await _forget_oldest(connection, site)
        return KeptNotice(number, now_us, notice, handled=False, groups={})

    async def mark_handled(self, number: int) -> None:
        """Write down that all rules were asked about a notice."""
        async with self._database.write() as connection:
            await connection.execute(
                update(alert_notices)
                .where(alert_notices.c.id == number)
                .values(handled_us=self._now_us())
            )

    async def list_notices(self, site: str, user: int, limit: int) -> list[KeptNotice]:
        """List the notices of a site's folder, and those that an account brought; newest first."""
        theirs = (alert_notices.c.user_id.in_([0, user]),)
        async with self._database.read() as connection:
            return await _read_notices(connection, site, theirs, limit)

    async def asked_of_event(self, site: str, notice: AlertNotice) -> dict[int, int]:
        """Give the groups that were asked for an event, or for what is cited, by rule."""
        about = [alert_notices.c.event_key == event_key(notice)]
        if notice.cites:
            keys = [notice_key(name) for name in notice.cites[:100]]
            about.append(alert_notices.c.notice_key.in_(keys))
        asked = (
            select(alert_outcomes.c.rule_id, alert_outcomes.c.group_id)
            .join(alert_notices, alert_notices.c.id == alert_outcomes.c.notice_id)
            .where(alert_notices.c.site == site, or_(*about))
        )
        async with self._database.read() as connection:
            return {row.rule_id: row.group_id for row in await connection.execute(asked)}

    def link_group(
        self, kept: KeptNotice, rule: KeptRule
    ) -> Callable[[AsyncConnection, int], Awaitable[None]]:
        """Give what writes, with the group itself, which notice it was made of."""

        async def write(connection: AsyncConnection, group: int) -> None:
            await connection.execute(
                insert(alert_outcomes).values(
                    rule_id=rule.id,
                    event_key=event_key(kept.notice),
                    notice_id=kept.id,
                    group_id=group,
                )
            )

        return write

    async def find_maker(self, user: int) -> AlertAsker | None:
        """Give who made a rule, with their rights; None: the account is gone or disabled."""
        asked = select(users.c.name, users.c.role_id).where(users.c.id == user, ~users.c.disabled)
        async with self._database.read() as connection:
            row = (await connection.execute(asked)).first()
            if row is None:
                return None
            held = await grants_of(connection, OF_ROLES, {row.role_id})
        return AlertAsker(user, row.name, held[row.role_id])

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000


async def _read_notices(
    connection: AsyncConnection, site: str, conditions: Sequence[ColumnElement[bool]], limit: int
) -> list[KeptNotice]:
    rows = (
        await connection.execute(
            select(alert_notices)
            .where(alert_notices.c.site == site, *conditions)
            .order_by(alert_notices.c.id.desc())
            .limit(limit)
        )
    ).all()
    outcomes = await connection.execute(
        select(alert_outcomes).where(alert_outcomes.c.notice_id.in_([row.id for row in rows]))
    )
    groups: dict[int, dict[int, int]] = {}
    for outcome in outcomes:
        groups.setdefault(outcome.notice_id, {})[outcome.rule_id] = outcome.group_id
    return [
        KeptNotice(
            row.id,
            row.received_us,
            _NOTICE.decode(row.definition),
            handled=bool(row.handled_us),
            groups=groups.get(row.id, {}),
        )
        for row in rows
    ]


async def _forget_oldest(connection: AsyncConnection, site: str) -> None:
    """Leave the newest notices, and those that something was asked for."""
    newest = (
        select(alert_notices.c.id)
        .where(alert_notices.c.site == site)
        .order_by(alert_notices.c.id.desc())
        .offset(MOST_NOTICES)
        .limit(1)
    )
    last = (await connection.execute(newest)).scalar()
    if last is not None:
        used = select(alert_outcomes.c.notice_id)
        await connection.execute(
            delete(alert_notices).where(
                alert_notices.c.site == site,
                alert_notices.c.id <= last,
                alert_notices.c.id.not_in(used),
            )
        )


def _is_rule(kept: KeptRule) -> tuple[ColumnElement[bool], ...]:
    return (
        alert_rules.c.site == kept.site,
        alert_rules.c.proposal == kept.proposal,
        alert_rules.c.id == kept.id,
    )


_RULE = msgspec.json.Decoder(AlertRule)
_NOTICE = msgspec.json.Decoder(AlertNotice)
