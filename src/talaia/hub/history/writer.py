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
from talaia.hub.history.jobs import Append

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.clock import Clock
    from talaia.hub.history.engine import Checkpoints
    from talaia.hub.history.jobs import Job
    from talaia.hub.history.ledger import Ledger

__all__ = ["Writer"]

ENOUGH = 512
# More than this in one commit only makes the others wait longer.
MOST = 65_536

_LOG = logging.getLogger(__name__)
Answer = int | HistoryError


class _Waiting(NamedTuple):
    job: Job
    answer: asyncio.Future[int]


class Writer:
    """Takes jobs on the event loop and does them in its own thread, in order."""

    def __init__(
        self, ledger: Ledger, checkpoints: Checkpoints, clock: Clock, linger_s: float
    ) -> None:
        """Prepare; `start` begins."""
        self._ledger = ledger
        self._checkpoints = checkpoints
        self._clock = clock
        self._linger_s = linger_s
        self._changed = threading.Condition()
        self._queue: deque[_Waiting] = deque()
        self._samples = 0
        self._ending = False
        self._lost = False
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread: threading.Thread | None = None

    async def start(self) -> None:
        """Load the ledger and begin to write.

        Raises:
            HistoryError: the database cannot be opened, or its tables are missing.

        """
        self._loop = asyncio.get_running_loop()
        try:
            await asyncio.to_thread(self._ledger.load)
        except SQLAlchemyError as error:
            raise HistoryError(
                f"the database cannot be read: {getattr(error, 'orig', None) or error}",
                "check that it can be reached and that its tables are up to date",
            ) from error
        self._thread = threading.Thread(target=self._run, name="history-writer", daemon=True)
        self._thread.start()

    async def stop(self) -> None:
        """Write what waits, then end the thread."""
        with self._changed:
            self._ending = True
            self._changed.notify()
        if self._thread is not None:
            await asyncio.to_thread(self._thread.join)

    async def do(self, job: Job) -> int:
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

    def _run(self) -> None:
        began = self._clock.monotonic_ns() - SECOND
        while group := self._next_group(began):
            began = self._clock.monotonic_ns()
            answers = self._store([each.job for each in group])
            if self._loop is not None and not self._loop.is_closed():
                self._loop.call_soon_threadsafe(_tell, group, answers)
            self._checkpoints.after_commit(self._ledger.written)
            self._ledger.written = 0

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
                each = self._queue.popleft()
                size += len(each.job.columns) if isinstance(each.job, Append) else ENOUGH
                group.append(each)
            self._samples -= size
            return group

    def _store(self, jobs: Sequence[Job]) -> Sequence[Answer]:
        try:
            if self._lost:
                self._ledger.load()
            answers = self._ledger.store(jobs)
        except Exception as error:  # noqa: BLE001 - told to those who wait; the thread goes on
            return self._failed(jobs, error)
        if self._lost:
            _LOG.warning("history is stored again")
        self._lost = False
        return answers

    def _failed(self, jobs: Sequence[Job], error: Exception) -> Sequence[Answer]:
        reason = getattr(error, "orig", None) or error
        if not self._lost:
            _LOG.error("history cannot be stored; it waits at the gateways: %r", reason)
        self._lost = True
        if len(jobs) == 1 or isinstance(error, OperationalError):
            refusal = HistoryError(
                f"nothing can be stored: {reason}", "it is tried again with the next batch"
            )
            return [refusal] * len(jobs)
        # One of them is refused by the database; let the others not suffer for it.
        return [self._store([job])[0] for job in jobs]


def _tell(group: Sequence[_Waiting], answers: Sequence[Answer]) -> None:
    for each, answer in zip(group, answers, strict=True):
        if each.answer.done():  # its caller was cancelled
            continue
        if isinstance(answer, HistoryError):
            each.answer.set_exception(answer)
        else:
            each.answer.set_result(answer)
