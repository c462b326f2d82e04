"""An event loop on a clock that is moved: hours pass as fast as what happens in them is reckoned.

The loop's time is its `HandClock`'s. When nothing is ready it does not wait, but moves the clock on
to what is due next. What sleeps, has a time-out or asks the clock lives on one time that way:
simulator, gateway, planner's questions and the night's executor.

It may be paced, for people who look on: then time passes at most so many times as fast as it does
for them.

What is real stays real: a thread, a child process or a socket does not run faster. While
`real_work` is held, and while a thread works for the loop, time stands. So a slow machine makes a
run longer, and never another one.
"""

# ruff: noqa: ANN401 - asyncio and selectors have them so
from __future__ import annotations

import asyncio
import contextlib
import math
import selectors
import time
from typing import TYPE_CHECKING, Any

from talaia.clock import SECOND

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from talaia.clock import HandClock

__all__ = ["SimulatedLoop"]

# While time moves on, `SimulatedLoop.passing` is told after each such part of it (s).
PART_S = 0.4
# For real work that is under way nobody waits longer in one go (s, real).
REAL_WAIT_S = 1.0
# A paced loop that falls behind by more does not make up for it (s, real).
BEHIND_S = 0.5


class SimulatedLoop(asyncio.SelectorEventLoop):
    """See the module.

    Attributes:
        clock: its time; also that of everything which runs on it.
        passing: called while time moves. What counts itself as standing still when it was not
            asked for half a second is told here that it runs.

    """

    def __init__(self, clock: HandClock, least_s: float = 0.0) -> None:
        """Begin at the clock's time.

        Args:
            clock: is moved from here alone.
            least_s: time moves by so much at least, so that what is due ten times a second is
                looked at once in such a span: the price of a night falls with it.

        """
        self.clock, self._least_s = clock, least_s
        self.passing: Callable[[], None] = _nothing
        # Threads that work for it, and waits for something real: while there are any, time stands.
        self._real_works = 0
        # How many times as fast as real time it may be, and since when it is counted.
        self._speed = math.inf
        self._paced_from = 0.0, 0.0
        # With another selector the base class would wait in real time.
        super().__init__(_LeapingSelector(self))

    def time(self) -> float:
        """Give the clock's monotonic time (s)."""
        return self.clock.monotonic_ns() / SECOND

    def pace_time(self, speed: float) -> None:
        """Let time pass at most so many times as fast as it really does; infinite: at once."""
        self._speed = speed
        self._paced_from = self.time(), time.monotonic()

    def real_wait(self, seconds: float) -> float:
        """Say how long is really to be waited until so much later (s) is now."""
        if math.isinf(self._speed):
            return 0.0
        from_s, real_s = self._paced_from
        then = self.time() + max(seconds, self._least_s)
        wait = real_s + (then - from_s) / self._speed - time.monotonic()
        if wait < -BEHIND_S:
            self._paced_from = then, time.monotonic()
        return max(0.0, wait)

    @contextlib.contextmanager
    def real_work(self) -> Iterator[None]:
        """Let no time pass meanwhile: something real is waited for."""
        self._real_works += 1
        try:
            yield
        finally:
            self._real_works -= 1

    @property
    def stands(self) -> bool:
        """Whether time stands, for real work is under way."""
        return self._real_works > 0

    def leap(self, seconds: float) -> None:
        """Move the clock on; called when nothing is ready."""
        # Rounded up: what is due is due then, and does not come a nanosecond early.
        left = math.ceil(max(seconds, self._least_s) * SECOND) + 1
        while left > 0:
            part = min(left, round(PART_S * SECOND))
            self.clock.advance(part)
            left -= part
            self.passing()

    def run_in_executor(  # type: ignore[override]  # typeshed's own is generic over the result
        self, executor: Any, func: Callable[..., Any], *args: Any
    ) -> asyncio.Future[Any]:
        """Run on a thread; time stands until it has ended."""
        future = super().run_in_executor(executor, func, *args)
        # Its end comes over the loop's own socket, so that a real select sees it.
        self._real_works += 1
        future.add_done_callback(self._end_work)
        return future

    def _end_work(self, _future: asyncio.Future[Any]) -> None:
        self._real_works -= 1


def _nothing() -> None: ...


class _LeapingSelector(selectors.BaseSelector):
    """Looks at real files without waiting, and moves the clock instead."""

    def __init__(self, loop: SimulatedLoop) -> None:
        self._loop, self._real = loop, selectors.DefaultSelector()

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        # First: what real files bring is of now, and comes before any later moment.
        ready = self._real.select(0)
        if ready or (timeout is not None and timeout <= 0):
            return ready
        # Nothing is due before a file or a thread speaks: that is waited for in real time.
        if timeout is None or self._loop.stands:
            return self._real.select(REAL_WAIT_S)
        wait = self._loop.real_wait(timeout)
        if wait > 0.0:
            # Most of it at once; what is left is waited for in the next turn, or what came is read.
            ready = self._real.select(min(wait, REAL_WAIT_S))
            if ready or wait > REAL_WAIT_S:
                return ready
        # The base class looks at its timers behind this, by the time that it is then.
        self._loop.leap(timeout)
        return ready

    def register(self, fileobj: Any, events: int, data: Any = None) -> selectors.SelectorKey:
        return self._real.register(fileobj, events, data)

    def unregister(self, fileobj: Any) -> selectors.SelectorKey:
        return self._real.unregister(fileobj)

    def modify(self, fileobj: Any, events: int, data: Any = None) -> selectors.SelectorKey:
        return self._real.modify(fileobj, events, data)

    def get_map(self) -> Mapping[Any, selectors.SelectorKey]:
        return self._real.get_map()

    def close(self) -> None:
        self._real.close()
