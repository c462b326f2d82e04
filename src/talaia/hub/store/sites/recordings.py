"""The list of recordings. The files themselves are in the data folder."""

from __future__ import annotations

import json
from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import delete, insert, select, update

from talaia.hub.store.history_servers.own_rows import every_row
from talaia.hub.store.tables import recordings

if TYPE_CHECKING:
    from talaia.hub.store.database import Database
    from talaia.hub.store.history_servers.own_rows import OwnRows

__all__ = ["Recorded", "RecordingList", "RecordingState"]

_table = recordings


class RecordingState(StrEnum):
    """Where a recording stands."""

    UPLOADING = "uploading"
    COMPLETE = "complete"
    FAILED = "failed"


class Recorded(NamedTuple):
    """A recording of raw topics, or a film of a camera.

    Attributes:
        messages: how many are in it; of a film its pictures.
        have: bytes that are here.
        digest: SHA-256 of all of it, as its gateway said.
        note: what is missing in it, or why it failed.
        stream: the camera that it is a film of (``device/stream``); empty where it holds topics.

    """

    site: str
    id: str
    state: RecordingState
    why: str
    who: str
    note: str
    begin_us: int
    end_us: int
    size: int
    have: int
    messages: int
    digest: str
    topics: tuple[str, ...]
    stream: str = ""


class RecordingList:
    """Rows of recordings."""

    def __init__(self, database: Database, own: OwnRows = every_row) -> None:
        """Work on ``database``; of all sites, only ``own`` ones are listed."""
        self._database = database
        self._own = own

    async def recordings_of(self, site: str) -> list[Recorded]:
        """List a site's recordings, the newest first."""
        return await self._select_recordings(_table.c.site == site)

    async def recordings_between(self, site: str, from_us: int, to_us: int) -> list[Recorded]:
        """List what a site has of a stretch of time, the newest first."""
        return await self._select_recordings(
            _table.c.site == site, _table.c.begin_us <= to_us, _table.c.end_us >= from_us
        )

    async def list_recordings(self) -> list[Recorded]:
        """List every recording of own sites, the newest first."""
        return await self._select_recordings(*self._own(_table.c.site))

    async def find_recording(self, site: str, name: str) -> Recorded | None:
        """Find one."""
        found = await self._select_recordings(_table.c.site == site, _table.c.id == name)
        return found[0] if found else None

    async def save_recording(self, recorded: Recorded) -> None:
        """Write a row, in place of the one that is there."""
        row = {
            **recorded._asdict(),
            "state": recorded.state.value,
            "topics": json.dumps(recorded.topics),
        }
        same = (_table.c.site == recorded.site, _table.c.id == recorded.id)
        async with self._database.write() as connection:
            there = await connection.execute(select(_table.c.id).where(*same))
            if there.first() is None:
                await connection.execute(insert(_table).values(**row))
            else:
                await connection.execute(update(_table).where(*same).values(**row))

    async def remove_recording(self, site: str, name: str) -> bool:
        """Delete a row; False when there is none."""
        async with self._database.write() as connection:
            done = await connection.execute(
                delete(_table).where(_table.c.site == site, _table.c.id == name)
            )
        return done.rowcount == 1

    async def _select_recordings(self, *conditions: object) -> list[Recorded]:
        columns = (_table.c[name] for name in Recorded._fields)
        query = select(*columns).where(*conditions)  # type: ignore[arg-type]
        async with self._database.read() as connection:
            rows = await connection.execute(query.order_by(_table.c.begin_us.desc(), _table.c.id))
            return [
                Recorded(
                    **{
                        **row._asdict(),
                        "state": RecordingState(row.state),
                        "topics": tuple(json.loads(row.topics)),
                    }
                )
                for row in rows
            ]
