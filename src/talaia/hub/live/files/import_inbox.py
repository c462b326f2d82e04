"""What `talaia import` has left in the data folder goes into the history.

A parcel (see `talaia.hub.history.import_file`) is taken a few stretches at a time, so that what
comes from gateways meanwhile shares the commits. Its file goes when all of it is stored; a hub
that is killed before that takes it again from the beginning, which stores nothing twice.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import os
import time
from itertools import islice
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.errors import StoreDown
from talaia.hub.history.errors import HistoryError
from talaia.hub.history.import_file import (
    READY,
    ParcelDamaged,
    boot_of,
    read_parcel,
    remove_abandoned,
)
from talaia.hub.sharding.plan import WholeShard

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable
    from pathlib import Path

    from talaia.hub.history.import_file import Head, ImportChunk
    from talaia.hub.ports import History, Shard

__all__ = ["ANSWER", "BAD", "ImportInbox", "ImportResult", "answer_of"]

_LOG = logging.getLogger(__name__)
ANSWER, BAD = ".done", ".bad"
# How often the folder is looked at (s).
_LOOK_S = 0.5
# Stretches of about four thousand samples that share a commit, and the rest after each.
_AT_ONCE = 8
_REST_S = 0.005
# An answer that nobody has fetched by then is deleted (s).
_ANSWERS_KEPT_S = 3600.0


class ImportResult(NamedTuple):
    """How a parcel was taken over.

    Attributes:
        stored: samples that were not there.
        there: samples that were there already.

    """

    stored: int
    there: int


class ImportInbox:
    """The folder of parcels."""

    def __init__(
        self,
        history: History,
        folder: Path,
        taken: Callable[[Head, ImportResult], Awaitable[None]],
        *,
        shard: Shard | None = None,
    ) -> None:
        """Store into ``history``; ``taken`` is told of each parcel that is stored.

        What is not of ``shard`` another hub takes out of the same folder; none: all is taken.
        """
        self._shard: Shard = shard or WholeShard()
        # Parcels that are for others; whose a site is does not change.
        self._others: set[str] = set()
        self._history = history
        self._folder = folder
        self._taken = taken
        # It was said that the database does not take imports; once for each failure.
        self._waits = False

    async def run(self) -> None:
        """Take parcels as they come, until cancelled."""
        await asyncio.to_thread(self._tidy_folder)
        while True:
            # Sorted, so that the order does not hang on the file system.
            found = sorted(self._folder.glob(f"*{READY}"))
            self._others.intersection_update(path.name for path in found)
            for path in found:
                if path.name not in self._others:
                    await self._try_import(path)
            await asyncio.sleep(_LOOK_S)

    async def import_file(self, path: Path) -> ImportResult:
        """Store one parcel and remove its file.

        Raises:
            ParcelDamaged: the file is not a parcel, or not all of it.
            HistoryError: the database does not take it; the file stays.

        """
        head, stretches = await asyncio.to_thread(read_parcel, path)
        stored = there = 0
        # By address: what of this file was stored before this attempt.
        before: dict[str, int] = {}
        while group := await asyncio.to_thread(lambda: list(islice(stretches, _AT_ONCE))):
            for batch in group:
                if batch.address not in before:
                    # The file's digest and the address name a run, so a second import stores
                    # nothing twice.
                    boot = boot_of(head.digest, batch.address)
                    before[batch.address] = await self._history.stored_below(head.site, boot)
            await asyncio.gather(*(self._append_chunk(head, batch) for batch in group))
            for batch in group:
                count = len(batch.columns)
                known = min(count, max(0, before[batch.address] - batch.first))
                there, stored = there + known, stored + count - known
            await asyncio.sleep(_REST_S)
        taken = ImportResult(stored, there)
        await self._taken(head, taken)
        # Last: until then the file stays, and is taken again after a crash.
        await asyncio.to_thread(self._answer, path, taken)
        _LOG.info(
            "%s is in the history of %s: %d samples, and %d were there already",
            head.file,
            head.site,
            stored,
            there,
        )
        return taken

    async def _append_chunk(self, head: Head, stretch: ImportChunk) -> None:
        boot = boot_of(head.digest, stretch.address)
        await self._history.append_samples(
            head.site, boot, stretch.first, addresses=[stretch.address], columns=stretch.columns
        )

    async def _try_import(self, path: Path) -> None:
        try:
            if not self._shard.is_whole and not await self._is_own(path):
                self._others.add(path.name)
                return
            await self.import_file(path)
        # Whoever put it there has taken it back.
        except FileNotFoundError:
            return
        except ParcelDamaged as error:
            # Of one without a head nobody can tell whose it is.
            if not self._shard.is_main and not await asyncio.to_thread(_has_head, path):
                return
            _LOG.error("an import is set aside: %s", error)
            # Kept for people under another name, and not tried again.
            await asyncio.to_thread(path.rename, path.with_suffix(BAD))
        except (HistoryError, StoreDown, OSError) as error:
            if not self._waits:
                _LOG.warning("an import waits: %s", error)
            self._waits = True
        else:
            self._waits = False

    async def _is_own(self, path: Path) -> bool:
        head, _ = await asyncio.to_thread(read_parcel, path)
        return await self._shard.look_up(head.site)

    def _answer(self, path: Path, taken: ImportResult) -> None:
        partial = path.with_suffix(ANSWER + ".tmp")
        # Under another name first: whoever waits never reads half of it.
        partial.write_text(json.dumps(taken._asdict()))
        partial.replace(path.with_suffix(ANSWER))
        # After the answer is there, or whoever waits would find neither.
        path.unlink()

    def _tidy_folder(self) -> None:
        remove_abandoned(self._folder)
        # An answer that nobody has fetched: its reader was ended.
        for path in self._folder.glob(f"*{ANSWER}*"):
            # Whoever waits for it, or another hub on this folder, may be quicker.
            with contextlib.suppress(FileNotFoundError):
                if time.time() - os.stat(path).st_mtime > _ANSWERS_KEPT_S:
                    path.unlink()


def _has_head(path: Path) -> bool:
    try:
        read_parcel(path)
    except (ParcelDamaged, OSError):
        return False
    return True


def answer_of(path: Path) -> ImportResult | None:
    """Give how a parcel was taken over, once, or none as long as it is not."""
    answer = path.with_suffix(ANSWER)
    try:
        found = ImportResult(**json.loads(answer.read_text()))
    except FileNotFoundError:
        return None
    answer.unlink(missing_ok=True)
    return found
