"""The archive's pictures and rows: put in whole, found again by night, target, filter and place.

Long, because a file and its row are put in and found by the same names.
"""

from __future__ import annotations

import asyncio
import logging
import math
import re
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

from sqlalchemy import func, insert, or_, select

from talaia.hub.archive.fits_process import FitsProcess
from talaia.hub.archive.fits_reader import Facts, Looks, NotKept, TooMuchToRead, unread_facts
from talaia.hub.archive.frame_rows import (
    ArchivedFrame,
    Cone,
    HookState,
    MeasureState,
    Night,
    Wanted,
    row_to_frame,
)
from talaia.hub.archive.night import night_of
from talaia.hub.store.tables import frames as table

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Collection
    from contextlib import AbstractAsyncContextManager
    from pathlib import Path

    from sqlalchemy import Select

    from talaia.hub.files.ports import FileStore
    from talaia.hub.store.database import Database
    from talaia.wire.frames import ArchiveOffer

__all__ = ["Archive"]

log = logging.getLogger(__name__)
_MOST_ROWS = 5_000  # that a search by place reads at once
_MOST_CACHED = 64  # previews and looks at once


class Archive:
    """See the module.

    Attributes:
        files: where they are, by their `frame_key`.
        arrived: set with each new picture; cleared by whoever measures them.

    """

    def __init__(
        self,
        database: Database,
        files: FileStore,
        most_rows: int = _MOST_ROWS,
        *,
        hooked: bool = False,
        reader: FitsProcess | None = None,
    ) -> None:
        """Keep pictures in ``files``, by site and night; read ``most_rows`` at once.

        ``reader`` reads them. ``hooked``: new pictures wait to be handed over to the owner's hook.
        """
        self.arrived = asyncio.Event()
        self._hooked = hooked
        self._database = database
        self.files = files
        self._most_rows = most_rows
        # Pictures are large, and a gateway's word: one at a time is read, by another process.
        self._reader = FitsProcess() if reader is None else reader
        self._cached: dict[tuple[int, str], bytes | Looks] = {}  # by picture and form; oldest first

    async def archive_file(
        self, site: str, zone: str, offer: ArchiveOffer, path: Path
    ) -> ArchivedFrame:
        """Check a file that has come whole, and put it in; it is moved.

        One that takes more memory or time to read than may be had is kept unread, and marked.

        Raises:
            NotKept: it is not a picture in FITS.
            OSError: the disk does not take it.
            StoreError: the database or the store of files does not.

        """
        known = await self._of_digest(site, offer.digest)  # sent again: an answer got lost
        if known is not None:
            await asyncio.to_thread(path.unlink, missing_ok=True)
            return known
        try:
            facts = await self._reader.read_facts(site, path)
        except TooMuchToRead as error:
            # It may be all that there is of a night.
            facts = unread_facts(str(error))
        time_us = facts.time_us or offer.time_us
        facts = facts._replace(time_us=time_us)
        night = night_of(time_us, zone)
        name = _file_name(facts, offer)
        # Before its row: no row without a file. It is measured next, on this machine.
        await self.files.keep_file(_frame_key(site, night, name), path, near=True)
        row = {
            "site": site,
            "device": offer.device,
            "night": night,
            "name": name,
            "time_us": time_us,
            "target": facts.target,
            "target_key": facts.target.casefold(),
            "filter": facts.filter,
            "kind": facts.kind,
            "exposure_s": _nan_to_null(facts.exposure_s),
            "ra_deg": _nan_to_null(facts.ra_deg),
            "dec_deg": _nan_to_null(facts.dec_deg),
            "width": facts.width,
            "height": facts.height,
            "bytes": offer.size,
            "digest": offer.digest,
            "problems": "\n".join(facts.problems)[:4000],
            # What could not be read is not measured either.
            "measured": MeasureState.WAITS if facts.width else MeasureState.OLD,
            "hook": HookState.WAITS if self._hooked else HookState.NONE,
        }
        async with self._database.write() as connection:
            await connection.execute(insert(table).values(**row))
        kept = await self._of_digest(site, offer.digest)
        assert kept is not None  # noqa: S101 - it was just written
        self.arrived.set()
        return kept

    async def count_bytes(self, site: str) -> int:
        """Count what the pictures of a site take (bytes)."""
        query = select(func.coalesce(func.sum(table.c.bytes), 0)).where(table.c.site == site)
        async with self._database.read() as connection:
            return int((await connection.execute(query)).scalar_one())

    async def list_nights(self, site: str, devices: Collection[str]) -> list[Night]:
        """List nights, newest first, with what these cameras brought."""
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(table.c.night, func.count(), func.sum(table.c.bytes))
                .where(table.c.site == site, table.c.device.in_(devices))
                .group_by(table.c.night)
                .order_by(table.c.night.desc())
            )
            return [Night(night, int(count), int(size)) for night, count, size in rows]

    async def find_frames(
        self, site: str, devices: Collection[str], wanted: Wanted, limit: int
    ) -> tuple[list[ArchivedFrame], bool]:
        """Find pictures of these cameras, newest first, and tell whether there are more."""
        query = _query(site, devices, wanted).order_by(table.c.time_us.desc(), table.c.id.desc())
        cone = wanted.cone
        most = limit + 1  # one more tells whether there are more
        if cone is None:
            found = await self._read_frames(query.limit(most))
        else:
            found = await self._find_within(query, cone, most)
        return found[:limit], len(found) > limit

    async def each_batch(
        self, site: str, devices: Collection[str], wanted: Wanted
    ) -> AsyncIterator[list[ArchivedFrame]]:
        """Give all pictures that fit, the first that came first, so many at once as are read."""
        query, last = _query(site, devices, wanted).order_by(table.c.id), 0
        while batch := await self._read_frames(
            query.where(table.c.id > last).limit(self._most_rows)
        ):
            last = batch[-1].id
            yield [frame for frame in batch if wanted.cone is None or _in_cone(frame, wanted.cone)]

    async def _find_within(self, query: Select[Any], cone: Cone, most: int) -> list[ArchivedFrame]:
        """Find the newest ``most`` in a cone, of a query that gives the newest first."""
        found: list[ArchivedFrame] = []
        rest = query
        while True:
            # SQL narrows by declination only, so any number of rows may come before one that fits.
            batch = await self._read_frames(rest.limit(self._most_rows))
            found += [frame for frame in batch if _in_cone(frame, cone)]
            if len(found) >= most or len(batch) < self._most_rows:
                return found
            last = batch[-1]
            # From the last one on, not by an offset: what is archived meanwhile moves nothing.
            rest = query.where(
                table.c.time_us <= last.time_us,
                or_(table.c.time_us < last.time_us, table.c.id < last.id),
            )

    async def _read_frames(self, query: Select[Any]) -> list[ArchivedFrame]:
        async with self._database.read() as connection:
            return [row_to_frame(row) for row in (await connection.execute(query)).mappings()]

    async def find_frame(self, site: str, frame: int) -> ArchivedFrame | None:
        """Find one picture."""
        query = select(table).where(table.c.site == site, table.c.id == frame)
        async with self._database.read() as connection:
            row = (await connection.execute(query)).mappings().first()
        return None if row is None else row_to_frame(row)

    def frame_key(self, frame: ArchivedFrame) -> str:
        """Name its file in the store of files."""
        return _frame_key(frame.site, frame.night, frame.name)

    def frame_copy(self, frame: ArchivedFrame) -> AbstractAsyncContextManager[Path]:
        """Have its file on this machine's disk for as long as the block lasts.

        Raises:
            FileNotFoundError: it is not there any more; in a folder, whoever opens it sees that.
            FilesDown: the store of files does not answer.

        """
        return self.files.copy_file(self.frame_key(frame))

    async def frame_looks(self, frame: ArchivedFrame) -> Looks:
        """Give statistics, histogram and header.

        Raises:
            NotKept: the file cannot be read any more.
            TooMuchToRead: it takes too much to read.
            FilesDown: the store of files does not answer.

        """
        found = self._cached.get((frame.id, ""))
        if not isinstance(found, Looks):
            async with self._existing_copy(frame) as path:
                found = await self._reader.read_looks(frame.site, path)
            self._cache_result(frame.id, "", found)
        return found

    async def render_preview(self, frame: ArchivedFrame, stretch: str, px: int) -> bytes:
        """Draw it as PNG.

        Raises:
            NotKept: the file cannot be read any more.
            TooMuchToRead: it takes too much to read.
            FilesDown: the store of files does not answer.

        """
        what = f"{stretch} {px}"
        found = self._cached.get((frame.id, what))
        if not isinstance(found, bytes):
            async with self._existing_copy(frame) as path:
                found = await self._reader.draw_preview(frame.site, path, stretch, px)
            self._cache_result(frame.id, what, found)
        return found

    def forget_looks(self, frame: ArchivedFrame) -> None:
        """Forget a header that was read: the file has new cards. Its pixels are as before."""
        self._cached.pop((frame.id, ""), None)

    @asynccontextmanager
    async def _existing_copy(self, frame: ArchivedFrame) -> AsyncIterator[Path]:
        try:
            async with self.frame_copy(frame) as path:
                yield path
        except FileNotFoundError as error:
            raise NotKept("it is not there") from error

    def _cache_result(self, frame: int, what: str, value: bytes | Looks) -> None:
        while len(self._cached) >= _MOST_CACHED:
            del self._cached[next(iter(self._cached))]
        self._cached[frame, what] = value

    async def _of_digest(self, site: str, digest: str) -> ArchivedFrame | None:
        query = select(table).where(table.c.site == site, table.c.digest == digest)
        async with self._database.read() as connection:
            row = (await connection.execute(query)).mappings().first()
        return None if row is None else row_to_frame(row)


def _query(site: str, devices: Collection[str], wanted: Wanted) -> Select[Any]:
    query = select(table).where(
        table.c.site == site,
        table.c.device.in_(devices),
        table.c.time_us >= wanted.from_us,
        table.c.time_us <= wanted.to_us,
    )
    if wanted.night:
        query = query.where(table.c.night == wanted.night)
    if wanted.target:
        query = query.where(table.c.target_key.contains(wanted.target.casefold(), autoescape=True))
    if wanted.filter:
        query = query.where(table.c.filter == wanted.filter)
    if wanted.kind:
        query = query.where(table.c.kind == wanted.kind)
    if (cone := wanted.cone) is not None:
        query = query.where(
            table.c.dec_deg >= cone.dec_deg - cone.radius_deg,
            table.c.dec_deg <= cone.dec_deg + cone.radius_deg,
        )
    return query


def _frame_key(site: str, night: str, name: str) -> str:
    return f"archive/{site}/{night}/{name}"


def _file_name(facts: Facts, offer: ArchiveOffer) -> str:
    """Make a file's name of safe characters only, unique by its digest."""
    from datetime import UTC, datetime

    at = datetime.fromtimestamp(facts.time_us / 1e6, UTC).strftime("%Y%m%dT%H%M%S")
    words = [_safe_word(offer.device), _safe_word(facts.target), _safe_word(facts.filter)]
    return "_".join([at, *filter(None, words), offer.digest[:8]]) + ".fits"


def _safe_word(word: str) -> str:
    return re.sub(r"[^A-Za-z0-9+-]+", "-", word).strip("-")[:40]  # no slash and no dot gets in


def _nan_to_null(value: float) -> float | None:
    return None if math.isnan(value) else value  # SQLite keeps no NaN


def _in_cone(frame: ArchivedFrame, cone: Cone) -> bool:
    if math.isnan(frame.ra_deg) or math.isnan(frame.dec_deg):
        return False
    a1, d1, a2, d2 = map(math.radians, (frame.ra_deg, frame.dec_deg, cone.ra_deg, cone.dec_deg))
    half = math.sin((d2 - d1) / 2) ** 2 + math.cos(d1) * math.cos(d2) * math.sin((a2 - a1) / 2) ** 2
    return math.degrees(2 * math.asin(min(1.0, math.sqrt(half)))) <= cone.radius_deg  # haversine
