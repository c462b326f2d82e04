"""Writes the command journal on the disk's thread, and says when the disk takes nothing."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import TYPE_CHECKING

from talaia.gateway.disk_trouble import DiskTrouble

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from talaia.gateway.commands.command_journal import CommandJournal
    from talaia.wire.frames import CommandState

__all__ = ["JournalWriter"]

_JOURNAL = "journal"
# What only makes safe waits no longer for the disk.
SAFE_WRITE_S = 0.5


class JournalWriter:
    """One journal. Event loop only.

    A write is a task: who must not act before it is on disk waits for it, all others do not.
    """

    def __init__(
        self,
        journal: CommandJournal,
        on_disk: Callable[[Callable[[], None]], Awaitable[None]],
        trouble: DiskTrouble | None = None,
    ) -> None:
        """Write nothing yet.

        Args:
            journal: see `CommandJournal`.
            on_disk: runs a blocking write elsewhere, in order; raises what it raises.
            trouble: told when the journal cannot be written, and when it can be again.

        """
        self._journal = journal  # Blocking; used on the disk's thread only.
        self._on_disk = on_disk  # Runs the journal's work in order.
        # Says a failing disk once, not at each write.
        self._trouble = DiskTrouble() if trouble is None else trouble
        # Held until they end, for the event loop itself keeps no task alive.
        self._writes: set[asyncio.Task[OSError | None]] = set()

    @property
    def remembered(self) -> list[CommandState]:
        """Give what an earlier run wrote."""
        return self._journal.remembered

    def compact_journal(self, states: list[CommandState]) -> None:
        """Write all anew (blocks), before anything else is written."""
        try:
            self._journal.compact_journal(states)
        except OSError as error:
            # It guards all the same; what is not safe is refused until it can be written.
            self._trouble.record_failure(_JOURNAL, error)

    def begin_write(self, state: CommandState, *, sure: bool) -> asyncio.Task[OSError | None]:
        """Begin to write a state, forced to disk if ``sure``; the task gives why it failed."""
        work = partial(self._journal.write_state, state, sure=sure)
        task = asyncio.ensure_future(self._write_on_disk(work, sure=sure))
        self._writes.add(task)
        task.add_done_callback(self._writes.discard)
        return task

    async def write_accepted(self, state: CommandState, *, guarded: bool, only_safe: bool) -> str:
        """Have it on disk that a command is about to be done; say why it may not be, if so.

        Args:
            state: what is written.
            guarded: a person asked for it, and not the gateway itself.
            only_safe: it can only make things safe, so it is done in any case.

        """
        writing = self.begin_write(state, sure=True)
        if not guarded:
            # The gateway's own ids never come again: nothing is gained by waiting.
            return ""
        if only_safe:
            # Half a second lets a working disk win; after that closing a roof goes first.
            await asyncio.wait([writing], timeout=SAFE_WRITE_S)
            return ""
        error = await writing
        return "" if error is None else f"the gateway cannot write its journal: {error}"

    async def _write_on_disk(self, work: Callable[[], None], *, sure: bool) -> OSError | None:
        try:
            await self._on_disk(work)
        except OSError as error:
            self._trouble.record_failure(_JOURNAL, error)
            return error
        if sure:
            # What is not forced to disk proves nothing of it.
            self._trouble.record_success(_JOURNAL)
        return None

    async def write_waiting(self) -> None:
        """Try again to write what the disk did not take."""
        if self._journal.behind or self._trouble.is_failing(_JOURNAL):
            await self._write_on_disk(self._journal.write_waiting, sure=True)

    async def close(self) -> None:
        """Finish the writes."""
        await asyncio.gather(*self._writes)
