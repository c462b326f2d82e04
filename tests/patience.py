"""How long tests wait for what must come.

Only what never comes takes so long: a machine that stands still for a minute fails no test. What
the product promises about time has a bound of its own, in the test that is about it: judged by the
clock of the part that keeps it, or by a `Stopwatch`.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Awaitable, Callable

PATIENCE_S = 180.0
PATIENCE_MS = PATIENCE_S * 1000
# How often is looked whether something still holds (s).
LOOK_S = 0.02
# How often another program is asked whether something has come (s): each answer costs it time.
ASK_S = 0.15


async def lasts_for(seconds: float) -> None:
    """Let what a test *does* last: a standstill, a fault, a pause of a person (s).

    Never for what has to come: that is waited for.
    """
    await asyncio.sleep(seconds)


def blocks_for(seconds: float) -> None:
    """Let what a test *does* last, where no event loop runs; see `lasts_for`."""
    threading.Event().wait(seconds)


async def stays(seconds: float, holds: Callable[[], bool], what: str) -> None:
    """Watch for ``seconds`` that something stays as it is: the only proof that nothing comes.

    Raises:
        AssertionError: it did not hold, as soon as this was seen; says ``what``.

    """
    ends = time.monotonic() + seconds
    while True:
        assert holds(), what
        if (left := ends - time.monotonic()) <= 0:
            return
        await asyncio.sleep(min(left, LOOK_S))


async def until_answered(ask: Callable[[], Awaitable[object]]) -> None:
    """Ask another program, with pauses that leave it time, until it says yes.

    Raises:
        AssertionError: it never did.

    """
    ends = time.monotonic() + PATIENCE_S
    while not await ask():
        assert time.monotonic() < ends, "it did not come to that"
        await asyncio.sleep(ASK_S)


class Stopwatch:
    """How long something takes, without the time for which a busy machine kept this process away.

    A thread wakes every few milliseconds; by how much it is late is what others had. A call that
    waits counts in full. Used as ``with Stopwatch() as watch: ...``.

    Attributes:
        seconds: so far.

    """

    STEP_S = 0.005

    def __init__(self) -> None:
        """Begin with none."""
        self.seconds = 0.0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Stopwatch:
        """Begin to measure."""
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """End."""
        self._ended.set()
        self._thread.join()

    def _run(self) -> None:
        before = time.monotonic()
        while not self._ended.wait(self.STEP_S):
            now = time.monotonic()
            self.seconds += min(now - before, 2 * self.STEP_S)
            before = now
