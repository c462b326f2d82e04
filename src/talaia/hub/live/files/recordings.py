"""Recordings that gateways hand over: taken in piece by piece, checked, kept within a size.

Each site has a room of its own: what one gateway announces or sends never takes the place of
another site's files, and takes that of its own only once it is whole and what it was said to be.

A recording is the file ``recordings/<site>/<id>.mcap`` (a camera's film: ``<id>.mp4``) with
``<id>.json`` beside it, and a row. The files come first: a row that was lost is made anew from
them at the next start, and nothing is deleted because a list does not name it.

Long, because every way a file may come, stop coming or go must leave file and row in step.
"""

from __future__ import annotations

import asyncio
import hashlib
import json
import logging
import os
import re
import shutil
import time
from contextlib import suppress
from typing import TYPE_CHECKING
from zlib import crc32

from starlette.websockets import WebSocketDisconnect

from talaia.first_completed import until_first
from talaia.hub.errors import StoreDown
from talaia.hub.live.files.coming_uploads import ComingUploads
from talaia.hub.store.sites.recordings import Recorded, RecordingState
from talaia.wire.errors import PeerError
from talaia.wire.frames import (
    FILES_FROM_GATEWAY,
    FILES_FROM_HUB,
    ArchiveOffer,
    Bye,
    FileOffer,
    FilePiece,
    FileProgress,
    FilmOffer,
)

if TYPE_CHECKING:
    from pathlib import Path

    from starlette.websockets import WebSocket

    from talaia.hub.live.files.uploads import Uploads
    from talaia.hub.live.gateways.open_links import OpenLinks
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.sites.recordings import RecordingList
    from talaia.hub.store.sites.site_registry import GatewayKey

__all__ = ["FOLDER", "FileLinks", "GatewayFiles", "Recordings"]

_LOG = logging.getLogger(__name__)
FOLDER = "recordings"
_MESSAGES, _FILM, _PART, _ABOUT = ".mcap", ".mp4", ".part", ".json"
# Of a film beside which nothing says whose it is.
_UNKNOWN = "unknown"
# Ids become names of files: no dot and no slash, so none leaves its folder.
_ID = re.compile(r"[0-9A-Za-z]{1,32}(-[0-9a-z]{1,16})?", re.ASCII)
# Sites become names of folders, and the same holds.
_SITE = re.compile(r"[a-z][a-z0-9_]{0,62}", re.ASCII)
# One that does not read must not hold up the end (s).
_FAREWELL_S = 0.5
# What a socket raises when the other side has gone or does not take anything.
_GONE = (WebSocketDisconnect, RuntimeError, OSError, TimeoutError)
_SPARE_BYTES = 256 * 1024 * 1024
# So many of one site may be on their way at once; a gateway sends one after the other.
_MOST_COMING = 100
# An upload that nobody has gone on with for so long ends (s): a robot may be away for days.
_STANDSTILL_S = 14 * 86_400


class GatewayFiles:
    """One open connection that brings files."""

    def __init__(self, socket: WebSocket) -> None:
        """Speak over ``socket``, which is accepted already."""
        self._socket = socket
        # Somebody has dismissed it.
        self._over = asyncio.Event()
        # Why; the first reason stays.
        self._reason = ""

    def dismiss_gateway(self, reason: str) -> None:
        """Say good-bye and close."""
        self._reason = self._reason or reason
        self._over.set()

    async def serve_files(self, recordings: Recordings, uploads: Uploads, site: str) -> None:
        """Take files until either side ends it."""
        results = await until_first(self._read_events(recordings, uploads, site), self._over.wait())
        reason, code = self._reason, 1000
        for result in results:
            if isinstance(result, PeerError):
                reason, code = result.problem, result.code
            elif isinstance(result, StoreDown):
                # 1013: try again later; what has come stays.
                reason, code = "the hub cannot store anything now; try again later", 1013
            elif isinstance(result, Exception) and not isinstance(result, _GONE):
                raise result
        try:
            async with asyncio.timeout(_FAREWELL_S):
                await self._socket.send_bytes(FILES_FROM_HUB.encode(Bye(reason=reason[:2000])))
                await self._socket.close(code)
        except _GONE:
            return

    async def _read_events(self, recordings: Recordings, uploads: Uploads, site: str) -> None:
        # The file that is being sent on this connection: pieces name it by its id.
        offered: FileOffer | FilmOffer | ArchiveOffer | None = None
        while True:
            event = await self._socket.receive()
            if event["type"] == "websocket.disconnect":
                return
            data = event.get("bytes")
            message = FILES_FROM_GATEWAY.decode(event.get("text", "") if data is None else data)
            match message:
                case FileOffer() | FilmOffer():
                    offered = message
                    answer = await recordings.answer_offer(site, message)
                case ArchiveOffer():
                    offered = message
                    answer = await uploads.answer_offer(site, message)
                case _:
                    if offered is None or offered.id != message.id:
                        raise PeerError("a piece of a file that was not offered")
                    if not isinstance(offered, ArchiveOffer):
                        answer = await recordings.append_piece(site, offered, message)
                    else:
                        answer = await uploads.append_piece(site, offered, message)
            await self._socket.send_bytes(FILES_FROM_HUB.encode(answer))


class FileLinks:
    """Takes in the files of gateways: recordings, films and pictures for the archive."""

    def __init__(self, *, links: OpenLinks, recordings: Recordings, uploads: Uploads) -> None:
        """Keep in ``recordings`` and ``uploads``; ``links`` closes who has a revoked key."""
        self._links = links
        self._recordings = recordings
        self._uploads = uploads

    async def serve_socket(self, socket: WebSocket, key: GatewayKey) -> None:
        """Take a gateway's recordings and pictures until it has handed over all."""
        files = GatewayFiles(socket)
        with self._links.count_open(key.id, files):
            await files.serve_files(self._recordings, self._uploads, key.site)


class Recordings:
    """The folder of recordings and its list."""

    def __init__(self, rows: RecordingList, audit: Audit, data: Path, most_bytes: int) -> None:
        """Keep files in ``data``; of a site's above ``most_bytes`` the oldest go (0: no limit)."""
        # One row for each recording; files are the truth, see `open`.
        self._rows = rows
        self._audit = audit
        self._folder = data / FOLDER
        # All recordings of one site together (bytes); 0: as much as the disk holds.
        self._most_bytes = most_bytes
        # What is on its way takes the room of its bytes on the disk, not of what is announced.
        self._coming = ComingUploads()
        # One thing at a time for each recording: two connections may bring the same.
        self._turn = asyncio.Lock()

    def file_path(self, recorded: Recorded) -> Path:
        """Give the file of a complete recording."""
        return self._file_with(recorded, _file_ending(recorded))

    async def recordings_of(self, site: str) -> list[Recorded]:
        """List a site's recordings, the newest first."""
        return await self._rows.recordings_of(site)

    async def recordings_between(self, site: str, from_us: int, to_us: int) -> list[Recorded]:
        """List what a site has of a stretch of time (µs, UTC), the newest first."""
        return await self._rows.recordings_between(site, from_us, to_us)

    async def find_recording(self, site: str, name: str) -> Recorded | None:
        """Find one."""
        # Ids from a request are checked before they become a path.
        return await self._rows.find_recording(site, name) if _ID.fullmatch(name) else None

    async def open(self) -> None:
        """Bring files and rows together: what has a file gets a row, and nothing is deleted.

        Raises:
            StoreDown: the database does not answer.

        """
        rows = {(row.site, row.id): row for row in await self._rows.list_recordings()}
        found = await asyncio.to_thread(self._scan_folder)
        for key, recorded in found.items():
            before = rows.get(key)
            # What lies in the folder counts, whatever its row says.
            if recorded.state is RecordingState.UPLOADING:
                touched = await asyncio.to_thread(self._touched, recorded)
                self._coming.begin_upload(*key, recorded.have, touched)
            if before is None or before.state is not recorded.state:
                _LOG.info("the recording %s of %s is in the list again", key[1], key[0])
                await self._rows.save_recording(recorded)
        for key, row in rows.items():
            if key not in found and row.state is not RecordingState.FAILED:
                note = "its file is not there"
                failed = row._replace(state=RecordingState.FAILED, note=note, have=0)
                await self._rows.save_recording(failed)
                _LOG.warning("the file of the recording %s of %s is not there", key[1], key[0])

    async def answer_offer(self, site: str, offer: FileOffer | FilmOffer) -> FileProgress:
        """Answer an offer: how much of it is here."""
        async with self._turn:
            row = await self._rows.find_recording(site, offer.id)
            # The same id with another content: a complete recording is never written over.
            if row is not None and row.digest != offer.digest:
                return FileProgress(id=offer.id, refused="another recording has that name already")
            if row is not None and row.state is RecordingState.COMPLETE:
                return FileProgress(id=offer.id, have=row.size, done=True)
            if self._most_bytes and offer.size > self._most_bytes:
                why = f"it is larger than all that may be kept ({self._most_bytes} bytes)"
                return FileProgress(id=offer.id, refused=why)
            if not _SITE.fullmatch(site) or not offer.size:
                return FileProgress(id=offer.id, refused="it cannot be kept")
            recorded = _recorded_of(site, offer)
            await self._end_standing_uploads(site, but=offer.id)
            others = self._coming.others_than(site, offer.id)
            # A gateway sends one after the other, so the first has been left. It may come again.
            for name in others[: max(0, len(others) + 1 - _MOST_COMING)]:
                await self._end_upload(site, name)
            try:
                have = await asyncio.to_thread(self._begin_file, recorded)
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
        async with self._turn:
            row = await self._rows.find_recording(site, offer.id)
            # Deleted while it came: the rest is refused, or it would come back without its
            # beginning.
            if row is None or row.state is RecordingState.FAILED or row.digest != offer.digest:
                return FileProgress(id=offer.id, refused="it was deleted here")
            if row.state is RecordingState.COMPLETE:
                return FileProgress(id=offer.id, have=row.size, done=True)
            await self._end_what_has_no_room(site, offer.id, len(piece.data))
            try:
                have = await asyncio.to_thread(self._write_piece, row, piece)
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
        async with self._turn:
            await self._delete_recording(recorded)

    async def _finish_file(self, row: Recorded) -> FileProgress:
        if not await asyncio.to_thread(self._check_part, row):
            self._coming.end_upload(row.site, row.id)
            note = "what came is not what its gateway has; it is sent again"
            _LOG.warning("the recording %s of %s: %s", row.id, row.site, note)
            await self._rows.save_recording(row._replace(have=0, note=note))
            return FileProgress(id=row.id, have=0)
        # Only now: what is announced, or is not what it was said to be, costs no other file.
        await self._make_room(row)
        await asyncio.to_thread(self._rename_part, row)
        self._coming.end_upload(row.site, row.id)
        await self._rows.save_recording(row._replace(state=RecordingState.COMPLETE, have=row.size))
        self._audit.append_record(
            "recording stored", site=row.site, message=f"{row.id}: {row.size} bytes; {row.why}"
        )
        return FileProgress(id=row.id, have=row.size, done=True)

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

    async def _end_standing_uploads(self, site: str, *, but: str) -> None:
        """End what nobody has gone on with for long, so that it keeps no place."""
        for name in self._coming.standing_uploads(site, time.time() - _STANDSTILL_S):
            if name == but:
                continue
            row = await self._rows.find_recording(site, name)
            self._coming.end_upload(site, name)
            if row is not None:
                await asyncio.to_thread(self._unlink_files, row)
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
        await asyncio.to_thread(self._unlink_files, recorded)
        await self._rows.remove_recording(recorded.site, recorded.id)

    # ── files; in a thread ──

    def _file_with(self, recorded: Recorded, ending: str) -> Path:
        return self._folder / recorded.site / (recorded.id + ending)

    def _part_path(self, recorded: Recorded) -> Path:
        return self._file_with(recorded, _file_ending(recorded) + _PART)

    def _begin_file(self, recorded: Recorded) -> int:
        folder = self._folder / recorded.site
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        # The database and the rest of the machine need the last of the disk more.
        if shutil.disk_usage(folder).free < recorded.size + _SPARE_BYTES:
            raise OSError("the disk is full")
        about = self._file_with(recorded, _ABOUT)
        # Under another name first: a hub that is killed leaves no half of it.
        partial = about.with_suffix(".json.tmp")
        partial.write_text(json.dumps({**recorded._asdict(), "state": recorded.state.value}))
        partial.replace(about)
        part = self._part_path(recorded)
        have = part.stat().st_size if part.exists() else 0
        # Of another file with that name: it cannot be its beginning.
        if have > recorded.size:
            part.unlink()
            have = 0
        return have

    def _write_piece(self, recorded: Recorded, piece: FilePiece) -> int:
        number = os.open(self._part_path(recorded), os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        try:
            have = os.fstat(number).st_size
            # Only what follows: a piece that came twice is there already.
            if piece.at == have:
                done = os.pwrite(number, piece.data, piece.at)
                # A full disk may take a part of it: taken back, so that the file ends with a whole
                # piece.
                if done < len(piece.data):
                    os.ftruncate(number, have)
                    raise OSError("the disk is full")
                have += done
            return have
        finally:
            os.close(number)

    def _check_part(self, recorded: Recorded) -> bool:
        """Tell whether what came is what was offered; what is not is deleted."""
        part = self._part_path(recorded)
        with part.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
            # On disk before it is called complete: the gateway need not keep its own after that.
            os.fsync(file.fileno())
        if digest != recorded.digest:
            part.unlink()
        return digest == recorded.digest

    def _rename_part(self, recorded: Recorded) -> None:
        # Only a whole file has the name without `.part`.
        self._part_path(recorded).rename(self.file_path(recorded))

    def _touched(self, recorded: Recorded) -> float:
        """Give when something of it was written last (s since the epoch, UTC)."""
        # What was only offered has nothing but the words beside it.
        for path in (self._part_path(recorded), self._file_with(recorded, _ABOUT)):
            with suppress(FileNotFoundError):
                return path.stat().st_mtime
        return 0.0

    def _unlink_files(self, recorded: Recorded) -> None:
        for path in (
            self.file_path(recorded),
            self._part_path(recorded),
            self._file_with(recorded, _ABOUT),
        ):
            path.unlink(missing_ok=True)

    def _scan_folder(self) -> dict[tuple[str, str], Recorded]:
        found = {}
        endings = {kind + state: kind for kind in (_MESSAGES, _FILM) for state in ("", _PART)}
        for path in sorted(self._folder.glob("*/*.m*")):
            site, name = path.parent.name, path.name.split(".", 1)[0]
            ending = path.name[len(name) :]
            if ending in endings and _ID.fullmatch(name) and _SITE.fullmatch(site):
                described = self._describe_file(path, site, name, whole=ending == endings[ending])
                # What stands beside it may say nothing, but the ending tells a film.
                film = endings[ending] == _FILM
                stream = (described.stream or _UNKNOWN) if film else ""
                found[site, name] = described._replace(stream=stream)
        return found

    def _describe_file(self, path: Path, site: str, name: str, *, whole: bool) -> Recorded:
        """Say what a file is: by the words beside it, else by what the disk knows."""
        size = path.stat().st_size
        state = RecordingState.COMPLETE if whole else RecordingState.UPLOADING
        with suppress(OSError, ValueError, TypeError, KeyError):
            about = json.loads((path.parent / (name + _ABOUT)).read_text())
            told = Recorded(**{**about, "topics": tuple(about["topics"])})
            # What lies there decides, not what was written about it.
            return told._replace(
                site=site, id=name, state=state, have=size, size=size if whole else told.size
            )
        end_us = path.stat().st_mtime_ns // 1000
        return Recorded(
            site, name, state, "found in the folder", "", "", end_us, end_us, size, size, 0, "", ()
        )


def _file_ending(recorded: Recorded) -> str:
    return _FILM if recorded.stream else _MESSAGES


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
        stream=(offer.stream or _UNKNOWN) if isinstance(offer, FilmOffer) else "",
    )
