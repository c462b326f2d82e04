"""How long tests wait for what must come.

Only what never comes takes so long: a machine that stands still for a minute fails no test. What
the product promises about time has a bound of its own, in the test that is about it: judged by the
clock of the part that keeps it, or by a `Stopwatch`.
"""

from __future__ import annotations

import threading
import time

PATIENCE_S = 180.0
PATIENCE_MS = PATIENCE_S * 1000


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
