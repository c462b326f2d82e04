"""The thread that makes pictures: the newest of each camera, and all cameras in turn."""

from __future__ import annotations

import threading
from types import SimpleNamespace
from typing import Any

from patience import PATIENCE_S

from talaia.clock import SystemClock
from talaia.gateway.cores.shared_budget import SharedBudget
from talaia.gateway.video.worker import PictureWorker


class Slow:
    """A `PictureStream` that stands at a gate, and keeps what it was given."""

    is_blurred = False

    def __init__(
        self,
        address: str,
        gate: threading.Semaphore,
        finished: threading.Semaphore,
        made: list[tuple[str, object]],
    ) -> None:
        """Be called ``address``."""
        self.address, self._gate, self._finished, self._made = address, gate, finished, made
        self.began = threading.Event()

    def is_due(self, _mono_ns: int) -> bool:
        return True

    def process_picture(self, raw: object, *_: object, divisor: int) -> None:
        self.began.set()
        self._gate.acquire()
        self._made.append((self.address, raw))
        self._finished.release()


def test_while_one_is_made_the_newest_of_each_camera_waits_and_all_have_their_turn() -> None:
    gate, finished = threading.Semaphore(0), threading.Semaphore(0)
    made: list[tuple[str, object]] = []
    one, two, three = (Slow(f"cam/{each}", gate, finished, made) for each in range(3))
    sink: Any = SimpleNamespace()
    worker = PictureWorker(sink, SystemClock(), SharedBudget(64))
    worker.start()
    try:
        worker.offer_raw(one, 0)  # type: ignore[arg-type]
        assert one.began.wait(PATIENCE_S)
        # The quick one comes again and again, and takes nobody's place by it.
        for number in range(1, 5):
            for stream in (two, one, three):
                worker.offer_raw(stream, number)  # type: ignore[arg-type]
        for _ in range(4):
            gate.release()
        for _ in range(4):
            assert finished.acquire(timeout=PATIENCE_S)
    finally:
        for _ in range(9):
            gate.release()
        worker.close()
    assert made[:1] == [("cam/0", 0)]
    assert sorted(made[1:]) == [("cam/0", 4), ("cam/1", 4), ("cam/2", 4)]
