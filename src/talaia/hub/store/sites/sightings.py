"""What cameras have seen: a row for each sighting, found by time, camera and class.

A sighting and its line in the logbook are one transaction: there is one line for each, whatever
happens to the hub.

Long, because what is kept and how it is found again are one table's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec
from sqlalchemy import and_, delete, exists, func, insert, or_, select, update

from talaia.hub.store.audit import append_entries
from talaia.hub.store.history_servers.own_rows import every_row
from talaia.hub.store.tables import seen_sightings, sightings

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Sequence

    from sqlalchemy import ColumnElement, Row
    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.hub.store.audit import AuditEntry
    from talaia.hub.store.database import Database
    from talaia.hub.store.history_servers.own_rows import OwnRows

__all__ = ["Kept", "Put", "Sighted", "SightingStore", "SightingsAsked"]

_table = sightings


class Sighted(NamedTuple):
    """Something that was seen; its site, camera, label and begin tell it apart.

    Attributes:
        camera: ``device/stream``.
        began_us: when it was seen first (UTC).
        ended_us: when it was seen last (UTC); 0 while it is in sight.
        many: how many at once, at the most.
        confidence: of the surest, 0 to 1.
        told_us: when the hub was told of it last, by its own clock (UTC).
        boot: the run that told it.
        story: its path, and what it did at zones and lines, as JSON; empty for none.
        picture: JPEG; empty for none, or to keep the one that is there.

    """

    site: str
    camera: str
    label: str
    began_us: int
    ended_us: int
    many: int
    confidence: float
    told_us: int
    boot: str
    story: str = ""
    picture: bytes = b""

    @property
    def key(self) -> tuple[str, str, str, int]:
        """What tells it apart."""
        return self.site, self.camera, self.label, self.began_us


class Kept(NamedTuple):
    """A sighting as it is kept; ``sighted`` is without its picture.

    Attributes:
        noted_us: the time of its line in the logbook; 0 before there is one.
        pictured: there is a picture.

    """

    id: int
    sighted: Sighted
    noted_us: int
    pictured: bool


class Put(NamedTuple):
    """A sighting that was written.

    Attributes:
        again: it was over before, too, so that nothing has happened.
        entry: the line that it has just got in the logbook.

    """

    kept: Kept
    again: bool
    entry: AuditEntry | None


@dataclass(frozen=True, slots=True, kw_only=True)
class SightingsAsked:
    """Which sightings are meant; what is None or empty does not matter.

    Attributes:
        from_us, to_us: in sight at any time from the one to the other, both included.
        cameras: only by one of these.
        open: only those that are in sight, or are not.
        before: only what began before this one did.
        zone: only what was in a zone of this name, or crossed a line of it.
        unseen_by: only what this person has not looked at.

    """

    from_us: int = 0
    to_us: int = 2**53
    cameras: Collection[str] = ()
    label: str = ""
    open: bool | None = None
    before: int | None = None
    zone: str = ""
    unseen_by: int | None = None


class SightingStore:
    """Rows of sightings."""

    def __init__(self, database: Database, own: OwnRows = every_row) -> None:
        """Work on ``database``; of all sites, only ``own`` ones are looked after."""
        self._database = database
        self._own = own

    async def save_sightings(
        self, told: Sequence[Sighted], note: Callable[[Sighted], AuditEntry | None]
    ) -> list[Put]:
        """Keep sightings in place of what was told of them before; all or nothing.

        Args:
            told: each at most once.
            note: gives the line that one gets in the logbook, now that it is over.

        Returns:
            Those of which anything was new, as they are kept now.

        Raises:
            StoreDown: nothing was kept.

        """
        written: list[Put] = []
        entries: list[AuditEntry] = []
        async with self._database.write() as connection:
            for sighting in told:
                # Told again on each new link until it is over, so mostly it is here already.
                before = await _find_existing(connection, sighting)
                if (
                    before is not None
                    and not sighting.picture
                    and _is_unchanged(before.sighted, sighting)
                ):
                    continue
                noted_us = before.noted_us if before else 0
                entry = note(sighting) if sighting.ended_us and not noted_us else None
                if entry is not None:
                    # By this a line of the logbook is led to its sighting.
                    late = entries and entry.time_us <= entries[-1].time_us
                    entry = entry._replace(time_us=entries[-1].time_us + 1) if late else entry
                    entries.append(entry)
                    noted_us = entry.time_us
                # Alarms go by this: what was over and is told once more must not ring a second
                # time.
                again = bool(before and before.sighted.ended_us and sighting.ended_us)
                kept = await _write_sighting(connection, sighting, before, noted_us)
                written.append(Put(kept, again, entry))
            if entries:
                await append_entries(connection, entries)
        return written

    async def list_open(self) -> list[Kept]:
        """List all of own sites that are in sight."""
        query = select(*_COLUMNS).where(_table.c.ended_us == 0, *self._own(_table.c.site))
        async with self._database.read() as connection:
            rows = await connection.execute(query)
            return [_row_to_sighting(row) for row in rows]

    async def find_sightings(
        self, site: str, asked: SightingsAsked, limit: int
    ) -> tuple[list[Kept], bool]:
        """List those that are meant, the last to begin first; tell whether there are more."""
        column = _table.c
        said = [
            column.site == site,
            # Those that the person may see; none of them finds nothing.
            column.camera.in_(sorted(asked.cameras)),
            column.began_us <= asked.to_us,
            or_(column.ended_us == 0, column.ended_us >= asked.from_us),
        ]
        if asked.label:
            said.append(column.label == asked.label)
        if asked.open is not None:
            said.append(column.ended_us == 0 if asked.open else column.ended_us != 0)
        if asked.zone:
            said.append(_tells_of(asked.zone))
        if asked.unseen_by is not None:
            mark = seen_sightings.c
            seen = exists().where(mark.sighting_id == column.id, mark.user_id == asked.unseen_by)
            said.append(~seen)
        async with self._database.read() as connection:
            if asked.before is not None:
                last = (
                    await connection.execute(
                        select(column.began_us).where(
                            column.site == site, column.id == asked.before
                        )
                    )
                ).scalar()
                # One that is not kept any more was the oldest.
                if last is None:
                    return [], False
                # Two cameras may see something in the same microsecond: pages must neither repeat
                # nor skip one.
                same = and_(column.began_us == last, column.id < asked.before)
                said.append(or_(column.began_us < last, same))
            rows = await connection.execute(
                select(*_COLUMNS)
                .where(*said)
                .order_by(column.began_us.desc(), column.id.desc())
                .limit(limit + 1)
            )
            found = [_row_to_sighting(row) for row in rows]
        return found[:limit], len(found) > limit

    async def find_noted(self, site: str, times: Collection[int]) -> list[Kept]:
        """List those whose lines in the logbook are of these times."""
        if not times:
            return []
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(*_COLUMNS).where(_table.c.site == site, _table.c.noted_us.in_(sorted(times)))
            )
            return [_row_to_sighting(row) for row in rows]

    async def seen_labels(self, site: str) -> list[tuple[str, str]]:
        """List what was ever seen, each camera with each label."""
        column = _table.c
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(column.camera, column.label)
                .where(column.site == site)
                .distinct()
                .order_by(column.camera, column.label)
            )
            return [(row.camera, row.label) for row in rows]

    async def sighting_picture(self, site: str, number: int) -> tuple[str, bytes] | None:
        """Give a sighting's camera and its picture, which may be empty; None: no such sighting."""
        column = _table.c
        async with self._database.read() as connection:
            row = (
                await connection.execute(
                    select(column.camera, column.picture).where(
                        column.site == site, column.id == number
                    )
                )
            ).first()
        return None if row is None else (row.camera, bytes(row.picture or b""))

    async def delete_old(self, before_us: int, most: int) -> int:
        """Forget what was told before a time, and what is more than ``most`` of an own site.

        What is in sight stays. Gives how many went.
        """
        column, gone = _table.c, 0
        async with self._database.write() as connection:
            over, own = column.ended_us != 0, self._own(column.site)
            done = await connection.execute(
                delete(_table).where(over, column.told_us < before_us, *own)
            )
            gone += done.rowcount
            # Of each site by itself, so that a busy one does not push out what others have seen.
            counted = await connection.execute(
                select(column.site, func.count()).where(*own).group_by(column.site)
            )
            for site, count in counted.all():
                if count <= most:
                    continue
                oldest = await connection.execute(
                    select(column.id)
                    .where(column.site == site, over)
                    .order_by(column.began_us, column.id)
                    .limit(count - most)
                )
                numbers = [row.id for row in oldest]
                # Databases bound how many values one statement may have.
                for at in range(0, len(numbers), _AT_ONCE):
                    some = numbers[at : at + _AT_ONCE]
                    await connection.execute(delete(_table).where(column.id.in_(some)))
                gone += len(numbers)
        return gone


_AT_ONCE = 500
_SAID = Sighted._fields[:-1]
_COLUMNS = tuple(_table.c[name] for name in ("id", *_SAID, "noted_us", "pictured"))


def _tells_of(name: str) -> ColumnElement[bool]:
    """Match stories with a zone or a line of a name, as `story_text` writes it."""
    word = msgspec.json.encode(name).decode()
    # Within the JSON a quotation mark of another text is escaped, so this is a key and its value.
    return or_(
        _table.c.story.contains(f'"zone":{word}', autoescape=True),
        _table.c.story.contains(f'"line":{word}', autoescape=True),
    )


def _row_to_sighting(row: Row[Any]) -> Kept:
    sighted = Sighted._make([*(getattr(row, name) for name in _SAID), b""])
    return Kept(row.id, sighted, row.noted_us, bool(row.pictured))


def _is_unchanged(before: Sighted, now: Sighted) -> bool:
    # When it was told is no news of what was seen.
    return before._replace(told_us=0) == now._replace(told_us=0)


async def _find_existing(connection: AsyncConnection, sighting: Sighted) -> Kept | None:
    found = await connection.execute(
        select(*_COLUMNS).where(
            _table.c.site == sighting.site,
            _table.c.camera == sighting.camera,
            _table.c.label == sighting.label,
            _table.c.began_us == sighting.began_us,
        )
    )
    row = found.first()
    return None if row is None else _row_to_sighting(row)


async def _write_sighting(
    connection: AsyncConnection, sighting: Sighted, before: Kept | None, noted_us: int
) -> Kept:
    row = {**sighting._asdict(), "noted_us": noted_us}
    if not row.pop("picture"):
        pictured = before.pictured if before else False
    else:
        row["picture"], pictured = sighting.picture, True
    row["pictured"] = pictured
    # Pictures are not kept in memory beside the row.
    bare = sighting._replace(picture=b"")
    if before is not None:
        await connection.execute(update(_table).where(_table.c.id == before.id).values(**row))
        return Kept(before.id, bare, noted_us, pictured)
    added = await connection.execute(insert(_table).values(**row))
    number = added.inserted_primary_key
    return Kept(int(number[0]) if number is not None else 0, bare, noted_us, pictured)
