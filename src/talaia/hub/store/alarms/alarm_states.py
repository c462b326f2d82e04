"""Alarms in the database: how each stands, what has happened to it, and those made in the page.

What happens to an alarm, its new state, the notices of it and its line in the logbook are one
transaction: a hub that is killed has either done all of it or none, and then does it again.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import delete, insert, select, update

from talaia.hub.alarms.state_machine import Happened, Phase, State, What
from talaia.hub.store.alarm_tables import alarm_definitions, alarm_history, alarm_states
from talaia.hub.store.alarms.notification_outbox import add_notices
from talaia.hub.store.audit import AuditEntry, append_entries
from talaia.hub.store.history_servers.own_rows import every_row
from talaia.hub.store.safe_text import safe_text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.hub.store.alarms.notification_outbox import About
    from talaia.hub.store.database import Database
    from talaia.hub.store.history_servers.own_rows import OwnRows

__all__ = ["AlarmChange", "AlarmStore", "MadeAlarm", "Past"]

# Characters that the columns hold.
_SENTENCE = 2000


class AlarmChange(NamedTuple):
    """An alarm's new state, and what happened to bring it about."""

    about: About
    state: State
    happened: tuple[Happened, ...]


class MadeAlarm(NamedTuple):
    """An alarm that was made in the page; the definition is JSON."""

    site: str
    alarm: str
    definition: str
    who: str
    changed_us: int


class Past(NamedTuple):
    """One thing that happened to an alarm."""

    id: int
    happened: Happened


class AlarmStore:
    """Rows of alarms."""

    def __init__(self, database: Database, own: OwnRows = every_row) -> None:
        """Work on ``database``, where rows may be of sites that others judge: not ``own``."""
        self._database = database
        self._own = own

    async def load_states(self) -> dict[tuple[str, str], State]:
        """Give how every alarm of own sites stands, by site and alarm."""
        query = select(alarm_states).where(*self._own(alarm_states.c.site))
        async with self._database.read() as connection:
            rows = await connection.execute(query)
            found = [dict(row._mapping) for row in rows]  # noqa: SLF001 - SQLAlchemy's own name
        return {
            (row.pop("site"), row.pop("alarm")): State(**{**row, "phase": Phase(row["phase"])})
            for row in found
        }

    async def commit_changes(self, changes: Sequence[AlarmChange], now_us: int) -> None:
        """Write states, what happened, and the notices of it, all or nothing."""
        async with self._database.write() as connection:
            entries: list[AuditEntry] = []
            for change in changes:
                about = change.about
                key = {"site": about.site, "alarm": about.alarm}
                same = (
                    alarm_states.c.site == about.site,
                    alarm_states.c.alarm == about.alarm,
                )
                row = {**dataclasses.asdict(change.state), "phase": change.state.phase.value}
                row["why"] = safe_text(change.state.why, _SENTENCE)
                row["shelved_why"] = safe_text(change.state.shelved_why, _SENTENCE)
                # Asked first: every engine has its own words for inserting or updating.
                there = await connection.execute(select(alarm_states.c.site).where(*same))
                if there.first() is None:
                    await connection.execute(insert(alarm_states).values(**key, **row))
                else:
                    await connection.execute(update(alarm_states).where(*same).values(**row))
                for happened in change.happened:
                    entries.append(_audit_entry(about, happened))
                    added = await connection.execute(
                        insert(alarm_history).values(
                            **key,
                            episode=happened.episode,
                            what=happened.what.value,
                            time_us=happened.time_us,
                            who=safe_text(happened.who, 200),
                            message=safe_text(happened.message, _SENTENCE),
                        )
                    )
                    number = added.inserted_primary_key
                    if happened.tell and number is not None:
                        await add_notices(
                            connection,
                            about,
                            happened_id=int(number[0]),
                            happened=happened,
                            now_us=now_us,
                        )
            if entries:
                await append_entries(connection, entries)

    async def alarm_history(
        self, site: str, alarm: str, limit: int, before: int = 2**62
    ) -> list[Past]:
        """List what has happened to an alarm, newest first."""
        table = alarm_history
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(table)
                .where(table.c.site == site, table.c.alarm == alarm, table.c.id < before)
                .order_by(table.c.id.desc())
                .limit(limit)
            )
            return [
                Past(
                    row.id,
                    Happened(What(row.what), row.episode, row.time_us, row.who, row.message),
                )
                for row in rows
            ]

    async def list_made(self) -> list[MadeAlarm]:
        """List the alarms of own sites that were made in the page."""
        query = select(alarm_definitions).where(*self._own(alarm_definitions.c.site))
        async with self._database.read() as connection:
            rows = await connection.execute(query)
            return [MadeAlarm(*row) for row in rows]

    async def save_made(self, made: MadeAlarm) -> None:
        """Keep an alarm that was made in the page, in place of the one of its name."""
        table = alarm_definitions
        same = (table.c.site == made.site, table.c.alarm == made.alarm)
        async with self._database.write() as connection:
            await connection.execute(delete(table).where(*same))
            await connection.execute(insert(table).values(**made._asdict()))

    async def delete_made(self, site: str, alarm: str) -> bool:
        """Remove an alarm that was made in the page; False when there is none."""
        table = alarm_definitions
        async with self._database.write() as connection:
            done = await connection.execute(
                delete(table).where(table.c.site == site, table.c.alarm == alarm)
            )
        return done.rowcount == 1


def _audit_entry(about: About, happened: Happened) -> AuditEntry:
    """Give the line of the logbook."""
    return AuditEntry(
        happened.time_us,
        f"alarm {happened.what}",
        safe_text(happened.who, 200),
        "",
        about.site,
        about.device,
        safe_text(f"{about.name}: {happened.message}".rstrip(": "), _SENTENCE),
        happened.what not in {What.RAISED, What.REMINDED, What.UNSHELVED},
    )
