"""Recordings that gateways hand over: taken in piece by piece, checked, kept within a size.

Each site has a room of its own: what one gateway announces or sends never takes the place of
another site's files, and takes that of its own only once it is whole and what it was said to be.

A recording is the file ``recordings/<site>/<id>.mcap`` (a camera's film: ``<id>.mp4``) with
``<id>.json`` beside it, and a row. The files come first: a row that was lost is made anew from
them at the next start, and nothing is deleted because a list does not name it. What has not come
whole is in the data folder; whole ones are where the hub keeps its files.

Long, because taking in, keeping within a size and handing out are steps of one file.
"""

from __future__ import annotations

import asyncio
import logging
import time
from typing import TYPE_CHECKING
from zlib import crc32

from talaia.hub.errors import StoreDown
from talaia.hub.live.files.coming_uploads import ComingUploads
from talaia.hub.live.files.recording_files import (
    FOLDER,
    UNKNOWN_STREAM,
    RecordingFiles,
    about_key,
    file_key,
    is_recording_id,
    is_site_folder,
)
from talaia.hub.live.files.site_turns import SiteTurns
from talaia.hub.live.files.standstill import STANDSTILL_S
from talaia.hub.store.sites.recordings import Recorded, RecordingState
from talaia.wire.errors import PeerError
from talaia.wire.frames import FileOffer, FilePiece, FileProgress, FilmOffer

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from talaia.hub.files.ports import FileStore
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.sites.recordings import RecordingList

__all__ = ["Recordings"]

_LOG = logging.getLogger(__name__)
# So many of one site may be on their way at once; a gateway sends one after the other.
_MOST_COMING = 100


class Recordings:
    """The folder of recordings and its list."""

    def __init__(
        self,
        *,
        rows: RecordingList,
        store: FileStore,
        audit: Audit,
        data: Path,
        most_bytes: int,
        has_site: Callable[[str], bool] = lambda _site: True,
    ) -> None:
        """Keep whole files in ``store``; of a site's above ``most_bytes`` the oldest go (0: none).

        What has not come whole is in ``data``, where files of sites may lie that others have:
        ``has_site`` tells.
        """
        self._has_site = has_site
        # One row for each recording; files are the truth, see `open`.
        self._rows = rows
        self._store = store
        self._audit = audit
        self._files = RecordingFiles(data / FOLDER)
        # All recordings of one site together (bytes); 0: as much as the disk holds.
        self._most_bytes = most_bytes
        # What is on its way takes the room of its bytes on the disk, not of what is announced.
        self._coming = ComingUploads()
        # One thing at a time for each site: two connections may bring the same.
        self._turns = SiteTurns()

    @property
    def store(self) -> FileStore:
        """Where whole files are, by their `file_key`."""
        return self._store

    @property
    def turns(self) -> SiteTurns:
        """Whose turn it is to change something of a site."""
        return self._turns

    async def recordings_of(self, site: str) -> list[Recorded]:
        """List a site's recordings, the newest first."""
        return await self._rows.recordings_of(site)

    async def recordings_between(self, site: str, from_us: int, to_us: int) -> list[Recorded]:
        """List what a site has of a stretch of time (µs, UTC), the newest first."""
        return await self._rows.recordings_between(site, from_us, to_us)

    async def find_recording(self, site: str, name: str) -> Recorded | None:
        """Find one."""
        # Ids from a request are checked before they become a path.
        return await self._rows.find_recording(site, name) if is_recording_id(name) else None

    async def open(self) -> None:
        """Bring files and rows together: what has a file gets a row, and nothing is deleted.

        Raises:
            StoreDown: the database does not answer.

        """
        rows = {(row.site, row.id): row for row in await self._rows.list_recordings()}
        found = await asyncio.to_thread(self._files.scan_folder, self._has_site)
        for key, recorded in found.items():
            before = rows.get(key)
            # What lies in the folder counts, whatever its row says.
            if recorded.state is RecordingState.UPLOADING:
                touched = await asyncio.to_thread(self._files.touched_s, recorded)
                self._coming.begin_upload(*key, recorded.have, touched)
            if before is None or before.state is not recorded.state:
                _LOG.info("the recording %s of %s is in the list again", key[1], key[0])
                await self._rows.save_recording(recorded)
        for key, row in rows.items():
            # Whole ones that are elsewhere are looked for once the hub is open.
            if self._store.remote and row.state is RecordingState.COMPLETE:
                continue
            if key not in found and row.state is not RecordingState.FAILED:
                note = "its file is not there"
                failed = row._replace(state=RecordingState.FAILED, note=note, have=0)
                await self._rows.save_recording(failed)
                _LOG.warning("the file of the recording %s of %s is not there", key[1], key[0])

    async def answer_offer(self, site: str, offer: FileOffer | FilmOffer) -> FileProgress:
        """Answer an offer: how much of it is here."""
        async with self._turns.wait_turn(site):
            row = await self._rows.find_recording(site, offer.id)
            # The same id with another content: a complete recording is never written over.
            if row is not None and row.digest != offer.digest:
                return FileProgress(id=offer.id, refused="another recording has that name already")
            if row is not None and row.state is RecordingState.COMPLETE:
                return FileProgress(id=offer.id, have=row.size, done=True)
            if self._most_bytes and offer.size > self._most_bytes:
                why = f"it is larger than all that may be kept ({self._most_bytes} bytes)"
                return FileProgress(id=offer.id, refused=why)
            if not is_site_folder(site) or not offer.size:
                return FileProgress(id=offer.id, refused="it cannot be kept")
            recorded = _recorded_of(site, offer)
            await self._end_standing_uploads(site, but=offer.id)
            others = self._coming.others_than(site, offer.id)
            # A gateway sends one after the other, so the first has been left. It may come again.
            for name in others[: max(0, len(others) + 1 - _MOST_COMING)]:
                await self._end_upload(site, name)
            try:
                have = await asyncio.to_thread(self._files.begin_file, recorded)
            except OSError as error:
                raise StoreDown(f"the recording cannot be written: {error}") from error
            self._coming.begin_upload(site, offer.id, have, time.time())
            await self._rows.save_recording(recorded._replace(have=have))
            if have == offer.size:
                return await self._finish_file(recorded)
            return FileProgress(id=offer.id, have=have)

    async def append_piece(
        self, site: str, offer: FileOffer | FilmOffer, piece: FilePiece
    ) -> FileProgress:
        """Take a piece of an offered file.

        Raises:
            PeerError: it does not fit.

        """
        if crc32(piece.data) != piece.check:
            raise PeerError("a piece that is not what its sum says")
        if piece.at + len(piece.data) > offer.size or not piece.data:
            raise PeerError("a piece that does not lie inside its file")
        async with self._turns.wait_turn(site):
            row = await self._rows.find_recording(site, offer.id)
            # Deleted while it came: the rest is refused, or it would come back without its
            # beginning.
            if row is None or row.state is RecordingState.FAILED or row.digest != offer.digest:
                return FileProgress(id=offer.id, refused="it was deleted here")
            if row.state is RecordingState.COMPLETE:
                return FileProgress(id=offer.id, have=row.size, done=True)
            await self._end_what_has_no_room(site, offer.id, len(piece.data))
            try:
                have = await asyncio.to_thread(self._files.write_piece, row, piece)
            except OSError as error:
                raise StoreDown(f"the recording cannot be written: {error}") from error
            due = self._coming.update_upload(site, offer.id, have, time.time())
            if have == offer.size:
                return await self._finish_file(row)
            if due:
                await self._rows.save_recording(row._replace(have=have))
            return FileProgress(id=offer.id, have=have)

    async def remove_recording(self, recorded: Recorded) -> None:
        """Delete a recording: the file first, so that nothing is left that no row names."""
        async with self._turns.wait_turn(recorded.site):
            await self._delete_recording(recorded)

    async def _finish_file(self, row: Recorded) -> FileProgress:
        if not await asyncio.to_thread(self._files.check_part, row):
            self._coming.end_upload(row.site, row.id)
            note = "what came is not what its gateway has; it is sent again"
            _LOG.warning("the recording %s of %s: %s", row.id, row.site, note)
            await self._rows.save_recording(row._replace(have=0, note=note))
            return FileProgress(id=row.id, have=0)
        await self._keep_file(row)
        # Only now: what is announced, or is not what it was said to be, costs no other file.
        await self._make_room(row)
        self._coming.end_upload(row.site, row.id)
        await self._rows.save_recording(row._replace(state=RecordingState.COMPLETE, have=row.size))
        self._audit.append_record(
            "recording stored",
            site=row.site,
            message=f"{row.id}: {row.size} bytes; {row.why}",
            source="gateway",
        )
        return FileProgress(id=row.id, have=row.size, done=True)

    async def _keep_file(self, row: Recorded) -> None:
        """Put a whole file where the hub keeps its files; the part stays where that fails."""
        if self._store.remote:
            # What is said of it goes first: of a file alone no row could be made.
            copy = await asyncio.to_thread(self._files.copy_about, row)
            await self._store.keep_file(about_key(row), copy)
        await self._store.keep_file(file_key(row), self._files.part_path(row))
        if self._store.remote:
            await asyncio.to_thread(self._files.unlink_files, row)

    async def _make_room(self, whole: Recorded) -> None:
        """Let the oldest of the same site go until a whole file has room."""
        if not self._most_bytes:
            return
        rows = [
            row
            for row in await self._rows.recordings_of(whole.site)
            if row.state is RecordingState.COMPLETE and row.id != whole.id
        ]
        total = whole.size + sum(row.size for row in rows)
        # From the oldest on: the list has the newest first.
        for oldest in reversed(rows):
            if total <= self._most_bytes:
                break
            await self._delete_recording(oldest)
            total -= oldest.size
            self._audit.append_record(
                "recording deleted",
                site=oldest.site,
                message=f"{oldest.id}: the oldest had to go, for those of a site may take"
                f" {self._most_bytes} bytes",
            )

    async def end_standing_uploads(self) -> None:
        """End uploads of any site that nobody has gone on with for long."""
        for site in self._coming.sites():
            async with self._turns.wait_turn(site):
                await self._end_standing_uploads(site)

    async def _end_standing_uploads(self, site: str, *, but: str = "") -> None:
        """End what nobody has gone on with for long, so that it keeps no place."""
        for name in self._coming.standing_uploads(site, time.time() - STANDSTILL_S):
            if name == but:
                continue
            row = await self._rows.find_recording(site, name)
            self._coming.end_upload(site, name)
            if row is not None:
                await asyncio.to_thread(self._files.unlink_files, row)
                note = "its gateway has not gone on with it for 14 days"
                failed = row._replace(state=RecordingState.FAILED, note=note, have=0)
                await self._rows.save_recording(failed)
                _LOG.warning("the recording %s of %s is given up: %s", name, site, note)

    async def _end_what_has_no_room(self, site: str, goes_on: str, more: int) -> None:
        """End uploads of a site, the first offered first, until more of another has room."""
        for name in self._coming.others_than(site, goes_on):
            if not self._most_bytes or self._coming.total_bytes(site) + more <= self._most_bytes:
                return
            await self._end_upload(site, name)

    async def _end_upload(self, site: str, name: str) -> None:
        row = await self._rows.find_recording(site, name)
        self._coming.end_upload(site, name)
        if row is not None:
            await self._delete_recording(row)

    async def _delete_recording(self, recorded: Recorded) -> None:
        self._coming.end_upload(recorded.site, recorded.id)
        # The file first: a row without a file is found at the next start, and says so.
        await self._store.remove_files([file_key(recorded), about_key(recorded)])
        await asyncio.to_thread(self._files.unlink_files, recorded)
        await self._rows.remove_recording(recorded.site, recorded.id)


def _recorded_of(site: str, offer: FileOffer | FilmOffer) -> Recorded:
    return Recorded(
        site=site,
        id=offer.id,
        state=RecordingState.UPLOADING,
        why=offer.why,
        who=offer.who,
        note=offer.note,
        begin_us=offer.begin_us,
        end_us=offer.end_us,
        size=offer.size,
        have=0,
        messages=offer.pictures if isinstance(offer, FilmOffer) else offer.messages,
        digest=offer.digest,
        topics=() if isinstance(offer, FilmOffer) else tuple(offer.topics),
        stream=(offer.stream or UNKNOWN_STREAM) if isinstance(offer, FilmOffer) else "",
    )
