"""An event loop in a thread of its own, for programs and notebooks that have none to give."""

from __future__ import annotations

import asyncio
import threading
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Coroutine

__all__ = ["EventLoopThread"]

T = TypeVar("T")

# What was cancelled may take so long to end (s).
_TIDY_S = 3.0


class EventLoopThread:
    """Runs coroutines for threads that wait for them."""

    def __init__(self) -> None:
        """Start the thread."""
        self._loop = asyncio.new_event_loop()
        # A program that ends does not wait for it.
        self._thread = threading.Thread(target=self._serve, name="talaia client", daemon=True)
        self._thread.start()

    def run_coroutine(self, coroutine: Coroutine[Any, Any, T]) -> T:
        """Run a coroutine to its end; Ctrl-C cancels it, and waits until it has tidied up."""
        call = _Call(coroutine)
        try:
            self._loop.call_soon_threadsafe(call.begin)
            return call.future.result()
        except BaseException:
            # Wherever Ctrl-C came, between the two lines above as well: zeros go out, and control
            # is given back.
            if not call.future.done():
                self._loop.call_soon_threadsafe(call.cancel)
                call.ended.wait(_TIDY_S)
            raise

    def stop_thread(self) -> None:
        """End the thread; what still runs is cancelled, and tidies up."""
        if self._loop.is_closed():
            return
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(timeout=10)

    def _serve(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_forever()
            left = asyncio.all_tasks(self._loop)
            for task in left:
                task.cancel()
            self._loop.run_until_complete(asyncio.gather(*left, return_exceptions=True))
            self._loop.run_until_complete(self._loop.shutdown_asyncgens())
        finally:
            self._loop.close()


class _Call(Generic[T]):
    """A coroutine on its way; all but ``future`` and ``ended`` is the loop's thread's.

    Attributes:
        future: what it came to.
        ended: it runs no more, or never will.

    """

    def __init__(self, coroutine: Coroutine[Any, Any, T]) -> None:
        self.future: Future[T] = Future()
        self.ended = threading.Event()
        self._coroutine = coroutine
        # None until it is begun.
        self._task: asyncio.Task[None] | None = None
        self._cancelled = False

    def begin(self) -> None:
        """Run it, unless it was cancelled before."""
        if not self._cancelled:
            self._task = asyncio.ensure_future(self._run())
            self._task.add_done_callback(lambda _: self._end())

    def cancel(self) -> None:
        """Cancel it; one that was never begun ends at once."""
        self._cancelled = True
        if self._task is not None:
            self._task.cancel()
        else:
            self._end()

    def _end(self) -> None:
        # One that was cancelled before its first step has not ended by itself.
        self._coroutine.close()
        self.ended.set()

    async def _run(self) -> None:
        try:
            self.future.set_result(await self._coroutine)
        except BaseException as error:  # noqa: BLE001 - it is raised in the thread that waits
            self.future.set_exception(error)
