"""A process of its own for what is reckoned from pictures; one that hangs is ended."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from typing import TYPE_CHECKING, ParamSpec, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["FrameReckoner"]

_Args = ParamSpec("_Args")
_Result = TypeVar("_Result")


class FrameReckoner(Executor):
    """One process, begun with the first work. Event loop only."""

    def __init__(self) -> None:
        """Begin nothing yet."""
        self._pool: ProcessPoolExecutor | None = None
        self._pid: Future[int] | None = None

    def submit(
        self, fn: Callable[_Args, _Result], /, *args: _Args.args, **kwargs: _Args.kwargs
    ) -> Future[_Result]:
        """See `Executor.submit`."""
        if self._pool is None:
            # Not forked: this process has threads.
            self._pool = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"))
            self._pid = self._pool.submit(os.getpid)
        return self._pool.submit(fn, *args, **kwargs)

    def end_process(self) -> None:
        """End the process, whatever it does; the next work begins another."""
        pool, pid, self._pool, self._pid = self._pool, self._pid, None, None
        if pool is None or pid is None:
            return
        if pid.done() and not pid.cancelled() and pid.exception() is None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid.result(), signal.SIGKILL)
        pool.shutdown(wait=False, cancel_futures=True)
