"""The thread that writes: everything that waits goes into one commit.

The first batch after a pause is committed at once. Under load a commit waits for a moment
after the last one began, so that many small batches share one wait for the disk; `ENOUGH` samples
end the waiting. Callers wait for their commit, which presses back on who sends too much.
"""

from __future__ import annotations

import asyncio
import logging
import threading
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy.exc import OperationalError, SQLAlchemyError

from talaia.clock import SECOND
from talaia.hub.history.errors import HistoryError
from talaia.hub.history.writing.writer_jobs import Append

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.clock import Clock
    from talaia.hub.history.engine import Checkpoints
    from talaia.hub.history.writing.block_index import BlockIndex
    from talaia.hub.history.writing.writer_jobs import Job

__all__ = ["Writer"]

ENOUGH = 512
# More than this in one commit only makes the others wait longer.
MOST = 65_536
# Whoever drives has the loop's next turn, however many gateways wait for a commit.
_ANSWERS_A_TURN = 32

_LOG = logging.getLogger(__name__)
Answer = int | HistoryError


class _Waiting(NamedTuple):
    job: Job
    answer: asyncio.Future[int]


class Writer:
    """Takes jobs on the event loop and does them in its own thread, in order."""

    def __init__(
        self, ledger: BlockIndex, checkpoints: Checkpoints, clock: Clock, linger_s: float
    ) -> None:
        """Prepare; `start` begins."""
        # What is known of the database; nobody else changes it.
        self._ledger = ledger
        # Are told of each commit, and do their part between two of them.
        self._checkpoints = checkpoints
        # Measures how long ago the last commit began.
        self._clock = clock
        # So long after the last commit began, the next one waits for more to come.
        self._linger_s = linger_s
        # Guards the queue, which the event loop fills and the writing thread empties.
        self._changed = threading.Condition()
        # Jobs in the order in which they came, each with the future of who waits for it.
        self._queue: deque[_Waiting] = deque()
        # Of the queue; a job that is no batch counts as `ENOUGH`, so that it waits for nobody.
        self._samples = 0
        # Set once: what waits is written, and nothing more is taken.
        self._ending = False
        # Why the last commit failed; empty when it did not.
        self.trouble = ""
        # Answers are given there, since futures belong to one loop; none before `start`.
        self._loop: asyncio.AbstractEventLoop | None = None
        # Daemon: a database that hangs must not keep the process from ending.
        self._thread: threading.Thread | None = None

    async def start(self) -> None:
        """Load the ledger and begin to write.

        Raises:
            HistoryError: the database cannot be opened, or its tables are missing.

        """
        self._loop = asyncio.get_running_loop()
        try:
            await asyncio.to_thread(self._ledger.load_index)
        except SQLAlchemyError as error:
            raise HistoryError(
                f"the database cannot be read: {getattr(error, 'orig', None) or error}",
                "check that it can be reached and that its tables are up to date",
            ) from error
        self._thread = threading.Thread(target=self._write_loop, name="history-writer", daemon=True)
        self._thread.start()

    async def stop(self) -> None:
        """Write what waits, then end the thread."""
        with self._changed:
            self._ending = True
            self._changed.notify()
        if self._thread is not None:
            await asyncio.to_thread(self._thread.join)

    async def complete_job(self, job: Job) -> int:
        """Wait until a job is durable.

        Raises:
            HistoryError: it is not stored.

        """
        if self._loop is None:
            raise HistoryError("it is not open", "call open first")
        waiting = _Waiting(job, self._loop.create_future())
        size = len(job.columns) if isinstance(job, Append) else ENOUGH
        with self._changed:
            if self._ending:
                raise HistoryError("it is closed")
            was = self._samples
            self._queue.append(waiting)
            self._samples += size
            # Waking the thread for each batch would cost more than storing it.
            if len(self._queue) == 1 or was < ENOUGH <= self._samples:
                self._changed.notify()
        return await waiting.answer

    def _write_loop(self) -> None:
        began = self._clock.monotonic_ns() - SECOND
        while group := self._next_group(began):
            began = self._clock.monotonic_ns()
            answers = self._answer_jobs([waiting.job for waiting in group])
            if self._loop is not None and not self._loop.is_closed():
                answered = deque(zip(group, answers, strict=True))
                self._loop.call_soon_threadsafe(_answer_waiting, self._loop, answered)
            try:
                self._checkpoints.after_commit(self._ledger.written)
                self._ledger.written = 0
                self._plan_ahead()
            except Exception:  # noqa: BLE001 - told below, with its trace
                # Without this thread nothing would be stored and everybody would wait for ever.
                _LOG.exception("what follows a commit failed; storing goes on")

    def _answer_jobs(self, jobs: Sequence[Job]) -> Sequence[Answer]:
        """Store, and have an answer for each job whatever happens."""
        try:
            return self._store_jobs(jobs)
        except Exception as error:  # noqa: BLE001 - told to those who wait
            _LOG.exception("storing failed in a way nobody foresaw; it goes on")
            self.trouble = _failure_reason(error)
            refusal = HistoryError(
                f"nothing can be stored: {error!r}", "it is tried again with the next batch"
            )
            return [refusal] * len(jobs)

    def _next_group(self, began: int) -> list[_Waiting]:
        with self._changed:
            while not self._queue and not self._ending:
                self._changed.wait()
            lingered_s = (self._clock.monotonic_ns() - began) / SECOND
            if lingered_s < self._linger_s:
                self._changed.wait_for(
                    lambda: self._samples >= ENOUGH or self._ending, self._linger_s - lingered_s
                )
            group: list[_Waiting] = []
            size = 0
            while self._queue and size < MOST:
                waiting = self._queue.popleft()
                size += len(waiting.job.columns) if isinstance(waiting.job, Append) else ENOUGH
                group.append(waiting)
            self._samples -= size
            return group

    def _store_jobs(self, jobs: Sequence[Job]) -> Sequence[Answer]:
        try:
            # What is in memory may be ahead of a database that took only half; read it anew.
            if self.trouble:
                self._ledger.load_index()
            answers = self._ledger.commit_jobs(jobs)
        except Exception as error:  # noqa: BLE001 - told to those who wait; the thread goes on
            return self._fail_jobs(jobs, error)
        if self.trouble:
            _LOG.warning("history is stored again")
        self.trouble = ""
        return answers

    def _plan_ahead(self) -> None:
        if self.trouble:
            return
        try:
            self._ledger.plan_writes()
        except Exception as error:  # noqa: BLE001 - what is committed is safe; the thread goes on
            _LOG.error("samples cannot be made blocks; it is tried again: %r", error)
            # Read anew before the next commit: what is planned in memory may be half of it.
            self.trouble = _failure_reason(error)

    def _fail_jobs(self, jobs: Sequence[Job], error: Exception) -> Sequence[Answer]:
        reason = getattr(error, "orig", None) or error
        if not self.trouble:
            _LOG.error("history cannot be stored; it waits at the gateways: %r", reason)
        self.trouble = _failure_reason(error)
        if len(jobs) == 1 or isinstance(error, OperationalError):
            refusal = HistoryError(
                f"nothing can be stored: {reason}", "it is tried again with the next batch"
            )
            return [refusal] * len(jobs)
        # One of them is refused by the database; let the others not suffer for it.
        return [self._store_jobs([job])[0] for job in jobs]


def _failure_reason(error: Exception) -> str:
    """Say why, for people; never empty."""
    reason = getattr(error, "orig", None) or error
    return str(reason) or type(reason).__name__


def _answer_waiting(
    loop: asyncio.AbstractEventLoop, answered: deque[tuple[_Waiting, Answer]]
) -> None:
    """Answer some, and the rest in the loop's next turn: each of them has something to do then."""
    for _ in range(min(_ANSWERS_A_TURN, len(answered))):
        waiting, answer = answered.popleft()
        if waiting.answer.done():  # its caller was cancelled
            continue
        if isinstance(answer, HistoryError):
            waiting.answer.set_exception(answer)
        else:
            waiting.answer.set_result(answer)
    if answered:
        loop.call_soon(_answer_waiting, loop, answered)
