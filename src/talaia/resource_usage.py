"""What this process uses just now, written to its log when SIGUSR1 asks for it.

For whoever suspects a leak: ``kill -USR1 PID`` costs the process nothing else and needs no page,
no account and no debugger. Tasks are counted by what they run, so that the line names what grows.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import signal
import threading
from collections import Counter
from functools import partial
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["describe_usage", "report_usage_on_signal"]

_LOG = logging.getLogger(__name__)
# One line of a log; what leaks is among the most frequent.
_MOST_NAMED = 15


def report_usage_on_signal(
    loop: asyncio.AbstractEventLoop, cached_bytes: Callable[[], int] | None = None
) -> None:
    """From now on write `describe_usage` to the log at each SIGUSR1, where there is that signal."""
    # Windows has none.
    if hasattr(signal, "SIGUSR1"):
        # On the loop, not in a signal handler: the set of tasks must not change while it is
        # counted.
        report = partial(describe_usage, loop, cached_bytes)
        loop.add_signal_handler(signal.SIGUSR1, lambda: _LOG.info("%s", report()))


def describe_usage(
    loop: asyncio.AbstractEventLoop, cached_bytes: Callable[[], int] | None = None
) -> str:
    """Say how many tasks, threads and open descriptors there are, and which tasks the most.

    ``cached_bytes``: gives the memory of what is kept only because it may be asked for again.
    """
    tasks = Counter(_what_runs(task) for task in asyncio.all_tasks(loop))
    named = ", ".join(f"{count} {name}" for name, count in tasks.most_common(_MOST_NAMED))
    figures = [f"tasks {tasks.total()}", f"threads {threading.active_count()}"]
    with contextlib.suppress(OSError):
        # Only Linux has /proc; elsewhere the line lacks this one.
        figures.append(f"descriptors {len(os.listdir('/proc/self/fd'))}")
    if cached_bytes is not None:
        figures.append(f"cached {cached_bytes() / 2**20:.2f} MiB")
    return f"usage: {', '.join(figures)}; tasks by what they run: {named}"


def _what_runs(task: asyncio.Task[object]) -> str:
    work = task.get_coro()
    # Not every awaitable has a name of its own; its type has one.
    return getattr(work, "__qualname__", type(work).__name__)
