"""An executor of rclpy that runs in a thread, and ends when it is told to."""

from __future__ import annotations

import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rclpy.executors import Executor


@contextmanager
def run_in_thread(executor: Executor) -> Iterator[None]:
    """Let it run meanwhile.

    `Executor.spin` waits without end, and misses a `shutdown` that comes at the wrong moment.
    """
    ended = threading.Event()

    def run() -> None:
        while not ended.is_set():
            executor.spin_once(timeout_sec=0.2)

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
        executor.shutdown(timeout_sec=1.0)
