"""A folder in which notices of transients are left, one in a file, for the hub to act upon."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from typing import TYPE_CHECKING

from talaia.hub.errors import StoreDown
from talaia.hub.live.observing.notice_readers import name_content
from talaia.hub.live.observing.observing_sites import is_observatory
from talaia.wire.alerts.read_notice import parse_notice
from talaia.wire.errors import PeerError

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.hub.live.observing.alert_intake import AlertIntake
    from talaia.hub.live.observing.notice_readers import NoticeReaders
    from talaia.hub.live.sites import Sites

__all__ = ["REFUSED", "TAKEN", "AlertFolder"]

_LOG = logging.getLogger(__name__)
# Folders inside it to which files go once they were read.
TAKEN, REFUSED = "taken", "refused"
_SUFFIXES = frozenset({".xml", ".json"})
# How often the folder is looked at (s): a telescope takes longer to turn.
_LOOK_S = 1.0
_MOST_BYTES = 1024 * 1024


class AlertFolder:
    """Reads files as they come, for every site that observes by itself."""

    def __init__(
        self, folder: Path, sites: Sites, intake: AlertIntake, readers: NoticeReaders | None = None
    ) -> None:
        """Read ``folder``; only files that end in ``.xml`` or ``.json`` are notices.

        ``readers``: who else reads them for sites of theirs; none: nobody.
        """
        self._folder = folder
        self._sites = sites
        self._intake = intake
        self._readers = readers

    async def run(self) -> None:
        """Take notices until cancelled."""
        while True:
            await self.read_files()
            await asyncio.sleep(_LOOK_S)

    async def read_files(self) -> None:
        """Take the notices that are there now."""
        for path in await asyncio.to_thread(self._list_files):
            try:
                await self._read_file(path)
            except StoreDown as error:
                # It stays, and is taken when the database is there again.
                _LOG.warning("a notice waits: %s", error)
                return
            except FileNotFoundError:
                # Another hub that reads the folder was quicker to move it.
                continue
            except OSError as error:
                _LOG.warning("a notice cannot be read: %s", error)

    def _list_files(self) -> list[Path]:
        try:
            found = [
                path
                for path in self._folder.iterdir()
                if path.suffix.lower() in _SUFFIXES and not path.name.startswith(".")
            ]
            # In the order in which they came: a retraction follows what it retracts.
            return sorted(found, key=lambda path: (path.stat().st_mtime_ns, path.name))
        except OSError as error:
            _LOG.warning("the folder of notices cannot be read: %s", error)
            return []

    async def _read_file(self, path: Path) -> None:
        readers = self._readers
        if readers is None:
            await self._take_file(path)
            return
        if not await asyncio.to_thread(readers.has_read, path):
            # Before it is read: what comes in its place meanwhile is not read yet.
            content = await asyncio.to_thread(name_content, path)
            if not await self._take_file(path, keep=True):
                return
            await asyncio.to_thread(readers.mark_read, path, content)
        # Only when all have: whoever is away for a while finds it when it is back.
        if await asyncio.to_thread(readers.may_move, path):
            await asyncio.to_thread(_move_file, path, TAKEN)
            await asyncio.to_thread(readers.forget_file, path)

    async def _take_file(self, path: Path, *, keep: bool = False) -> bool:
        """Act upon a notice, and move it away unless it is to ``keep``; False: it is none."""
        try:
            notice = parse_notice(await asyncio.to_thread(_read_bytes, path))
        except PeerError as error:
            _LOG.warning("%s is no notice: %s", path.name, error)
            await asyncio.to_thread(_move_file, path, REFUSED)
            return False
        for live in self._sites:
            if is_observatory(live.description):
                await self._intake.take_notice(live, notice)
        if not keep:
            await asyncio.to_thread(_move_file, path, TAKEN)
        return True


def _read_bytes(path: Path) -> bytes:
    with path.open("rb") as file:
        # One more than may be: the reader then says that it is too much.
        return file.read(_MOST_BYTES + 1)


def _move_file(path: Path, folder: str) -> None:
    into = path.parent / folder
    into.mkdir(exist_ok=True)
    with contextlib.suppress(FileNotFoundError):
        path.replace(into / path.name)
