"""What waits to be measured and to be handed over: two queues that outlive the hub."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

import msgspec
from sqlalchemy import select, update

from talaia.hub.archive.frame_rows import HookState, MeasureState, row_to_frame
from talaia.hub.store.history_servers.own_rows import every_row
from talaia.hub.store.tables import frames as table

if TYPE_CHECKING:
    from contextlib import AbstractAsyncContextManager
    from pathlib import Path

    from sqlalchemy import Select

    from talaia.hub.archive.frame_rows import ArchivedFrame
    from talaia.hub.archive.measure_child import MeasuredFile
    from talaia.hub.archive.store import Archive
    from talaia.hub.store.database import Database
    from talaia.hub.store.history_servers.own_rows import OwnRows

__all__ = ["FrameQueues"]


class FrameQueues:
    """Both are columns of the pictures' own rows.

    Attributes:
        measured: set with each picture that was measured; cleared by whoever hands them over.

    """

    def __init__(self, database: Database, archive: Archive, own: OwnRows = every_row) -> None:
        """Take pictures of ``archive``, of ``own`` sites, in the order in which they came."""
        self._database, self._archive, self._own = database, archive, own
        self.measured = asyncio.Event()

    @property
    def arrived(self) -> asyncio.Event:
        """Set with each new picture; cleared by whoever measures them."""
        return self._archive.arrived

    def frame_copy(self, frame: ArchivedFrame) -> AbstractAsyncContextManager[Path]:
        """See `Archive.frame_copy`."""
        return self._archive.frame_copy(frame)

    def frame_address(self, frame: ArchivedFrame) -> str:
        """Give the address of a picture in a bucket; empty: it is in the data folder."""
        return self._archive.files.address_of(self._archive.frame_key(frame))

    async def next_unmeasured(self) -> ArchivedFrame | None:
        """Find the oldest picture that waits to be measured."""
        return await self._first(
            select(table)
            .where(table.c.measured == MeasureState.WAITS, *self._own(table.c.site))
            .order_by(table.c.id)
            .limit(1)
        )

    async def keep_measures(
        self, frame: ArchivedFrame, measured: MeasuredFile, made: Path | None = None
    ) -> None:
        """Keep what was found out of a picture, and put its new file in the place of the old.

        ``made`` is the new file, where there is one; it is moved.
        """
        values = _measure_values(measured)
        if made is not None:
            # A hub that dies between file and row measures it once more, and finds the same.
            values["bytes"] = (await asyncio.to_thread(made.stat)).st_size
            await self._archive.files.keep_file(self._archive.frame_key(frame), made, near=True)
        async with self._database.write() as connection:
            await connection.execute(update(table).where(table.c.id == frame.id).values(**values))
        self._archive.forget_looks(frame)
        self.measured.set()

    async def next_for_hook(self) -> ArchivedFrame | None:
        """Find the oldest picture that the owner's hook has not had; none before it is measured."""
        found = await self._first(
            select(table)
            .where(table.c.hook == HookState.WAITS, *self._own(table.c.site))
            .order_by(table.c.id)
            .limit(1)
        )
        # In order: what came later waits behind one that is still measured.
        waits = found is None or found.measures.state is MeasureState.WAITS
        return None if waits else found

    async def mark_handed_over(self, frame: ArchivedFrame) -> None:
        """Write down that the owner's hook has had a picture."""
        async with self._database.write() as connection:
            await connection.execute(
                update(table).where(table.c.id == frame.id).values(hook=HookState.HANDED_OVER)
            )

    async def _first(self, query: Select[Any]) -> ArchivedFrame | None:
        async with self._database.read() as connection:
            row = (await connection.execute(query)).mappings().first()
        return None if row is None else row_to_frame(row)


def _measure_values(measured: MeasuredFile) -> dict[str, Any]:
    values: dict[str, Any] = {
        "measured": MeasureState.MEASURED,
        "stars": measured.stars,
        "fwhm": measured.fwhm,
        "background": measured.background,
        "zero_point": measured.zero_point,
        "wcs": msgspec.json.encode(measured.wcs).decode() if measured.wcs else "",
        "measure_note": measured.note[:400],
    }
    if measured.center:
        # Searched by from now on: a telescope that is a field off is found where it looked.
        values["ra_deg"], values["dec_deg"] = measured.center
    return values
