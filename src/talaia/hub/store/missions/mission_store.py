"""Missions that people made, and the runs of each."""

from __future__ import annotations

import json
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import delete, func, insert, select, update

from talaia.hub.store.history_servers.own_rows import every_row
from talaia.hub.store.mission_tables import mission_runs, missions
from talaia.hub.store.safe_text import safe_text
from talaia.hub.store.tables import users
from talaia.model.missions.mission_file import read_mission_json, write_mission_json

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from sqlalchemy import Row, Select
    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.clock import Clock
    from talaia.hub.store.database import Database
    from talaia.hub.store.history_servers.own_rows import OwnRows
    from talaia.model.missions.mission import Mission

__all__ = ["MOST_MISSIONS", "KeptMission", "MissionStore", "RunRecord", "StepRecord"]

# Of one site.
MOST_MISSIONS = 200
# Of one site; the oldest go.
MOST_RUNS = 500
# States of a run that is not over.
GOING_ON = ("running", "paused")
_LONGEST_WHY = 1000


class KeptMission(NamedTuple):
    """A mission with whose rights it runs by itself, and when (µs, UTC; 0: never)."""

    id: int
    site: str
    owner_id: int
    owner: str
    mission: Mission
    due_us: int
    changed_us: int


@dataclass(slots=True)
class StepRecord:
    """What became of one step: ``waiting``, ``running``, or how it ended; times are UTC."""

    name: str
    state: str = "waiting"
    message: str = ""
    began_us: int = 0
    ended_us: int = 0
    # Of the command that it asked for.
    command: str = ""


@dataclass(slots=True)
class RunRecord:
    """One run of a mission.

    Attributes:
        who: whose rights it has.
        begun_by: who pressed start, or ``schedule``.
        state: ``running``, ``paused``, ``succeeded``, ``failed``, ``stopped``, ``cancelled``,
            ``interrupted`` or ``missed``.
        why: it ended so, in words.

    """

    site: str
    mission_id: int
    name: str
    who: str
    begun_by: str
    began_us: int
    state: str = "running"
    why: str = ""
    ended_us: int = 0
    steps: list[StepRecord] = field(default_factory=list)
    id: int = 0


class MissionStore:
    """Rows of missions and of runs."""

    def __init__(self, database: Database, clock: Clock, own: OwnRows = every_row) -> None:
        """Work on ``database``; ``clock`` stamps what is saved.

        What is due, or was going on, is only of ``own`` sites: others do theirs.
        """
        self._database = database
        self._own = own
        self._clock = clock
        # When the next is due (µs, UTC; 0: never; None: not known), so that the database is not
        # asked each second. Whatever writes a due time forgets it, and all of that is below.
        self._next_due_us: int | None = None
        # Counts these writes: what was read beside one is not remembered.
        self._due_writes = 0

    async def list_missions(self, site: str = "") -> list[KeptMission]:
        """List those of a site, or of all; by name."""
        query = _select_missions().order_by(missions.c.name, missions.c.id)
        if site:
            query = query.where(missions.c.site == site)
        async with self._database.read() as connection:
            return [_mission_of(row) for row in await connection.execute(query)]

    async def find_mission(self, site: str, number: int) -> KeptMission | None:
        """Find one of a site."""
        query = _select_missions().where(missions.c.id == number, missions.c.site == site)
        async with self._database.read() as connection:
            row = (await connection.execute(query)).first()
        return None if row is None else _mission_of(row)

    async def add_mission(self, site: str, mission: Mission, owner: int, due_us: int) -> int | None:
        """Keep a new one; None when its site has as many as may be."""
        async with self._write_due_times() as connection:
            count = select(func.count()).where(missions.c.site == site)
            if int((await connection.execute(count)).scalar_one()) >= MOST_MISSIONS:
                return None
            added = await connection.execute(
                insert(missions).values(site=site, **self._columns(mission, owner, due_us))
            )
        return int(added.inserted_primary_key[0]) if added.inserted_primary_key else 0

    async def change_mission(
        self, site: str, number: int, *, mission: Mission, owner: int, due_us: int
    ) -> bool:
        """Save another version: from now on it is of whoever saved it."""
        async with self._write_due_times() as connection:
            changed = await connection.execute(
                update(missions)
                .where(missions.c.id == number, missions.c.site == site)
                .values(**self._columns(mission, owner, due_us))
            )
        return bool(changed.rowcount)

    async def remove_mission(self, site: str, number: int) -> bool:
        """Remove one; its runs stay."""
        async with self._database.write() as connection:
            gone = await connection.execute(
                delete(missions).where(missions.c.id == number, missions.c.site == site)
            )
        return bool(gone.rowcount)

    async def due_missions(self, now_us: int) -> list[KeptMission]:
        """List those of own sites whose schedule is due."""
        known, writes = self._next_due_us, self._due_writes
        if known is not None and (known == 0 or now_us < known):
            return []
        own = self._own(missions.c.site)
        query = _select_missions().where(missions.c.due_us > 0, missions.c.due_us <= now_us, *own)
        first = select(func.min(missions.c.due_us)).where(missions.c.due_us > 0, *own)
        async with self._database.read() as connection:
            due = [_mission_of(row) for row in await connection.execute(query)]
            next_us = int((await connection.execute(first)).scalar() or 0)
        if self._due_writes == writes:
            self._next_due_us = next_us
        return due

    async def claim_due(self, kept: KeptMission, next_us: int) -> bool:
        """Take a due time, so that it is acted on at most once, whatever happens next."""
        async with self._write_due_times() as connection:
            taken = await connection.execute(
                update(missions)
                .where(missions.c.id == kept.id, missions.c.due_us == kept.due_us)
                .values(due_us=next_us)
            )
        return bool(taken.rowcount)

    @asynccontextmanager
    async def _write_due_times(self) -> AsyncIterator[AsyncConnection]:
        try:
            async with self._database.write() as connection:
                yield connection
        finally:
            # Of one that failed it is not known what is written.
            self._next_due_us = None
            self._due_writes += 1

    async def add_run(self, run: RunRecord) -> None:
        """Keep a new run; it gets its number."""
        async with self._database.write() as connection:
            added = await connection.execute(insert(mission_runs).values(**_run_columns(run)))
            run.id = int(added.inserted_primary_key[0]) if added.inserted_primary_key else 0
            old = (
                select(mission_runs.c.id)
                .where(mission_runs.c.site == run.site)
                .order_by(mission_runs.c.id.desc())
                .offset(MOST_RUNS)
                .limit(1)
            )
            last = (await connection.execute(old)).scalar()
            if last is not None:
                await connection.execute(
                    delete(mission_runs).where(
                        mission_runs.c.site == run.site, mission_runs.c.id <= last
                    )
                )

    async def save_run(self, run: RunRecord) -> None:
        """Write down how a run stands."""
        async with self._database.write() as connection:
            await connection.execute(
                update(mission_runs).where(mission_runs.c.id == run.id).values(**_run_columns(run))
            )

    async def list_runs(self, site: str, limit: int) -> list[RunRecord]:
        """List the runs of a site, the newest first."""
        query = (
            select(mission_runs)
            .where(mission_runs.c.site == site)
            .order_by(mission_runs.c.id.desc())
            .limit(limit)
        )
        async with self._database.read() as connection:
            return [_run_of(row) for row in await connection.execute(query)]

    async def unfinished_runs(self) -> list[RunRecord]:
        """List those of own sites that were going on when the hub ended."""
        query = select(mission_runs).where(
            mission_runs.c.state.in_(GOING_ON), *self._own(mission_runs.c.site)
        )
        async with self._database.read() as connection:
            return [_run_of(row) for row in await connection.execute(query)]

    def _columns(self, mission: Mission, owner: int, due_us: int) -> dict[str, object]:
        return {
            "name": mission.name,
            "owner_id": owner,
            "text": write_mission_json(mission),
            "due_us": due_us,
            "changed_us": self._clock.wall_ns() // 1000,
        }


def _select_missions() -> Select[Any]:
    return select(missions, users.c.name.label("owner")).join(
        users, users.c.id == missions.c.owner_id
    )


def _mission_of(row: Row[Any]) -> KeptMission:
    return KeptMission(
        row.id,
        row.site,
        row.owner_id,
        row.owner,
        read_mission_json(row.text),
        row.due_us,
        row.changed_us,
    )


def _run_columns(run: RunRecord) -> dict[str, object]:
    steps = [
        {name: getattr(step, name) for name in StepRecord.__dataclass_fields__}
        for step in run.steps
    ]
    return {
        "site": run.site,
        "mission_id": run.mission_id,
        "name": run.name,
        "who": run.who,
        "begun_by": run.begun_by,
        "state": run.state,
        "why": safe_text(run.why, _LONGEST_WHY),
        "began_us": run.began_us,
        "ended_us": run.ended_us,
        "steps": json.dumps(steps),
    }


def _run_of(row: Row[Any]) -> RunRecord:
    return RunRecord(
        site=row.site,
        mission_id=row.mission_id,
        name=row.name,
        who=row.who,
        begun_by=row.begun_by,
        began_us=row.began_us,
        state=row.state,
        why=row.why,
        ended_us=row.ended_us,
        steps=[StepRecord(**step) for step in json.loads(row.steps)],
        id=row.id,
    )
