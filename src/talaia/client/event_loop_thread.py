"""An event loop in a thread of its own, for programs and notebooks that have none to give."""

from __future__ import annotations

import asyncio
import threading
from typing import TYPE_CHECKING, Any, TypeVar

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
        ended = threading.Event()

        async def guarded() -> T:
            try:
                return await coroutine
            finally:
                ended.set()

        future = asyncio.run_coroutine_threadsafe(guarded(), self._loop)
        try:
            return future.result()
        except BaseException:
            if future.cancel():
                # The future is done at once, the coroutine is not: zeros go out, and control is
                # given back.
                ended.wait(_TIDY_S)
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
