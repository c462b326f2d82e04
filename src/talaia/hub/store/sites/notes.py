"""Notes that people write about a moment or a span of a site, a device or a signal."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import and_, delete, func, insert, or_, select, update

from talaia.hub.store.note_tables import notes

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Collection

    from sqlalchemy import ColumnElement, Row

    from talaia.clock import Clock
    from talaia.hub.store.database import Database

__all__ = ["LONGEST_NOTE", "MOST_NOTES", "KeptNote", "NoteBody", "NoteFilter", "NoteStore"]

# Characters of one note.
LONGEST_NOTE = 4000
# Of one site.
MOST_NOTES = 100_000
# Rows that are read at a time.
_PAGE = 500


class NoteBody(NamedTuple):
    """What a person says of a note.

    Attributes:
        device: what it is about; empty for the whole site.
        signal: of that device; empty for all of it.
        from_us, to_us: both included (µs, UTC); the same for a moment.
        text: at most `LONGEST_NOTE` characters.

    """

    device: str
    signal: str
    from_us: int
    to_us: int
    text: str


class KeptNote(NamedTuple):
    """A note as it is kept.

    Attributes:
        author: the account that wrote it; None once there is no such account.
        who: the name that its author had.
        version: counts its changes, from 1.

    """

    id: int
    site: str
    body: NoteBody
    author: int | None
    who: str
    created_us: int
    changed_us: int
    changed_by: str
    version: int


@dataclass(frozen=True, slots=True, kw_only=True)
class NoteFilter:
    """Which notes are meant; what is None or empty does not matter.

    Attributes:
        from_us, to_us: any part of it lies from the one to the other, both included.
        devices: only about one of these; not about the site as a whole.
        device: only about this one.
        who: only by this author.
        text: each of its words stands in the note or its author's name, in any case.
        before: only what stands behind this note in the list.

    """

    from_us: int = 0
    to_us: int = 2**53
    devices: Collection[str] | None = None
    device: str = ""
    who: str = ""
    text: str = ""
    before: int | None = None


class NoteStore:
    """Rows of notes."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` stamps what is written."""
        self._database = database
        self._clock = clock

    async def find_notes(
        self, site: str, wanted: NoteFilter, limit: int
    ) -> tuple[list[KeptNote], bool]:
        """List those that are meant, the last to begin first; tell whether there are more."""
        said = [notes.c.site == site, *_conditions(wanted)]
        async with self._database.read() as connection:
            if wanted.before is not None:
                column = notes.c
                query = select(column.from_us).where(
                    column.site == site, column.id == wanted.before
                )
                last = (await connection.execute(query)).scalar()
                # One that was removed meanwhile has no place in the list.
                if last is None:
                    return [], False
                # Two may begin in the same microsecond: pages neither repeat nor skip one.
                same = and_(column.from_us == last, column.id < wanted.before)
                said.append(or_(column.from_us < last, same))
            rows = await connection.execute(
                select(notes)
                .where(*said)
                .order_by(notes.c.from_us.desc(), notes.c.id.desc())
                .limit(limit + 1)
            )
            found = [_note_of(row) for row in rows]
        return found[:limit], len(found) > limit

    async def iterate_notes(self, site: str, wanted: NoteFilter) -> AsyncIterator[KeptNote]:
        """Go through all that are meant, the last to begin first, with few of them in memory."""
        more = True
        while more:
            rows, more = await self.find_notes(site, wanted, _PAGE)
            for row in rows:
                yield row
            if rows:
                wanted = replace(wanted, before=rows[-1].id)

    async def find_note(self, site: str, number: int) -> KeptNote | None:
        """Find a note of a site by its number."""
        query = select(notes).where(notes.c.id == number, notes.c.site == site)
        async with self._database.read() as connection:
            row = (await connection.execute(query)).first()
        return None if row is None else _note_of(row)

    async def add_note(self, site: str, body: NoteBody, author: int, who: str) -> KeptNote | None:
        """Keep a new note.

        Returns:
            None when the site has as many as may be.

        """
        now = self._now_us()
        async with self._database.write() as connection:
            count = select(func.count()).where(notes.c.site == site)
            if int((await connection.execute(count)).scalar_one()) >= MOST_NOTES:
                return None
            added = await connection.execute(
                insert(notes).values(
                    site=site,
                    author_id=author,
                    who=who,
                    created_us=now,
                    changed_us=now,
                    changed_by=who,
                    version=1,
                    **body._asdict(),
                )
            )
            number = int(added.inserted_primary_key[0]) if added.inserted_primary_key else 0
        return KeptNote(number, site, body, author, who, now, now, who, 1)

    async def change_note(
        self, kept: KeptNote, body: NoteBody, *, base: int, who: str
    ) -> KeptNote | None:
        """Keep a note as it is now meant.

        Returns:
            None when its version is not ``base`` any more: somebody else was faster.

        """
        now = self._now_us()
        async with self._database.write() as connection:
            done = await connection.execute(
                update(notes)
                .where(notes.c.id == kept.id, notes.c.version == base)
                .values(changed_us=now, changed_by=who, version=base + 1, **body._asdict())
            )
            if done.rowcount != 1:
                return None
        return kept._replace(body=body, changed_us=now, changed_by=who, version=base + 1)

    async def remove_note(self, kept: KeptNote) -> bool:
        """Remove a note; False when somebody else was faster."""
        async with self._database.write() as connection:
            done = await connection.execute(delete(notes).where(notes.c.id == kept.id))
        return done.rowcount == 1

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000


def _conditions(wanted: NoteFilter) -> list[ColumnElement[bool]]:
    said: list[ColumnElement[bool]] = [
        notes.c.from_us <= wanted.to_us,
        notes.c.to_us >= wanted.from_us,
    ]
    if wanted.devices is not None:
        said.append(notes.c.device.in_(sorted(wanted.devices)))
    if wanted.device:
        said.append(notes.c.device == wanted.device)
    if wanted.who:
        said.append(notes.c.who == wanted.who)
    for word in wanted.text.lower().split():
        # What people type holds no wildcards: `%` and `_` stand for themselves.
        columns = (notes.c.text, notes.c.who, notes.c.device, notes.c.signal)
        said.append(
            or_(*(func.lower(column).contains(word, autoescape=True) for column in columns))
        )
    return said


def _note_of(row: Row[Any]) -> KeptNote:
    return KeptNote(
        id=row.id,
        site=row.site,
        body=NoteBody(row.device, row.signal, row.from_us, row.to_us, row.text),
        author=row.author_id,
        who=row.who,
        created_us=row.created_us,
        changed_us=row.changed_us,
        changed_by=row.changed_by,
        version=row.version,
    )
