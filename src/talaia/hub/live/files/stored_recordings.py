"""Brings recordings that are in a bucket and their list together, once the hub is open.

As in a folder: what has a file gets a row, a row without a file says so, and nothing is deleted.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from talaia.hub.errors import StoreDown
from talaia.hub.live.files.recording_files import (
    FOLDER,
    UNKNOWN_STREAM,
    about_key,
    describe_recording,
    file_key,
    found_recording,
    read_file_key,
)
from talaia.hub.store.sites.recordings import RecordingState

if TYPE_CHECKING:
    from talaia.hub.files.ports import FileStore, StoredFile
    from talaia.hub.live.files.recordings import Recordings
    from talaia.hub.ports import Shard
    from talaia.hub.store.sites.recordings import Recorded, RecordingList

__all__ = ["StoredRecordings"]

_LOG = logging.getLogger(__name__)
# Between two looks, and before the next one where the store did not answer (s).
_EVERY_S, _AGAIN_S = 86_400.0, 10.0
# What is said of a recording; a larger file says nothing.
_MOST_ABOUT = 1024 * 1024


class StoredRecordings:
    """See the module."""

    def __init__(self, recordings: Recordings, rows: RecordingList, shard: Shard) -> None:
        """Look at the store of ``recordings``, and put right ``rows``, of sites of ``shard``."""
        self._shard = shard
        self._store: FileStore = recordings.store
        self._turns = recordings.turns
        self._rows = rows

    async def fit_for_ever(self) -> None:
        """Do it once a day, until cancelled."""
        while True:
            try:
                await self.fit_list()
            except StoreDown:
                # Said already by whoever asked the store.
                await asyncio.sleep(_AGAIN_S)
                continue
            await asyncio.sleep(_EVERY_S)

    async def fit_list(self) -> None:
        """Bring them together.

        Raises:
            StoreDown: the store, or the database, does not answer.

        """
        found: dict[tuple[str, str], StoredFile] = {}
        async for stored in self._store.list_files(FOLDER):
            if (read := read_file_key(stored.key)) is not None:
                found[read[0], read[1]] = stored
        # Only now: whose a site is stands there before its first file does.
        await self._shard.refresh()
        found = {key: stored for key, stored in found.items() if self._shard.has_site(key[0])}
        rows = {(row.site, row.id): row for row in await self._rows.list_recordings()}
        # What is on its way is put into its row by who sends it.
        lost = [key for key in found if key not in rows or rows[key].state is RecordingState.FAILED]
        for site in sorted({site for site, _ in lost}):
            await self._add_rows(site, {name for owner, name in lost if owner == site})
        for key, row in rows.items():
            if key not in found and row.state is RecordingState.COMPLETE:
                await self._fail_row(row)

    async def _add_rows(self, site: str, names: set[str]) -> None:
        async with self._turns.wait_turn(site):
            # Once more, in the site's turn: some may have been deleted since.
            async for stored in self._store.list_files(f"{FOLDER}/{site}"):
                read = read_file_key(stored.key)
                if read is not None and read[1] in names:
                    await self._add_row(site, read[1], stored, film=read[2])

    async def _add_row(self, site: str, name: str, stored: StoredFile, *, film: bool) -> None:
        row = await self._rows.find_recording(site, name)
        if row is not None and row.state is not RecordingState.FAILED:
            return
        known = found_recording(site, name, stored.size, stored.changed_us)
        known = known._replace(why="found in the bucket", stream=UNKNOWN_STREAM if film else "")
        about = await self._read_about(known)
        await self._rows.save_recording(describe_recording(about, known))
        _LOG.info("the recording %s of %s is in the list again", name, site)

    async def _fail_row(self, row: Recorded) -> None:
        async with self._turns.wait_turn(row.site):
            now = await self._rows.find_recording(row.site, row.id)
            if now is None or now.state is not RecordingState.COMPLETE:
                return
            if await self._is_there(now):
                return
            note = "its file is not there"
            failed = now._replace(state=RecordingState.FAILED, note=note, have=0)
            await self._rows.save_recording(failed)
        _LOG.warning("the file of the recording %s of %s is not there", row.id, row.site)

    async def _is_there(self, recorded: Recorded) -> bool:
        try:
            file = await self._store.open_file(file_key(recorded))
        except FileNotFoundError:
            return False
        await file.close()
        return True

    async def _read_about(self, recorded: Recorded) -> bytes:
        try:
            file = await self._store.open_file(about_key(recorded))
        except FileNotFoundError:
            return b""
        try:
            return await file.read_part(0, min(file.size, _MOST_ABOUT))
        finally:
            await file.close()
