"""The thread that makes pictures; of those that wait, the newest of each camera wins.

They take no more of the cores than `CoreBudget` gives, and take turns by what each has cost.
"""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING

from talaia.gateway.cores.core_budget import PictureSize, Turns
from talaia.gateway.cores.shared_budget import SharedBudget

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.gateway.ports import PictureSink
    from talaia.gateway.video.camera import PictureStream

__all__ = ["PictureWorker"]


class _Waiting:
    """The newest picture of a stream that waits."""

    def __init__(self, stream: PictureStream) -> None:
        self.stream = stream
        self.raw: object = None
        self.time_us = self.mono_us = 0  # When it came, wall and monotonic (µs).
        self.lost = -1  # Older ones whose place it took.


class PictureWorker:
    """The encoding thread. At most one raw picture of each stream waits.

    It has no lower priority than the thread that drives: a thread that is put back while it holds
    the interpreter's lock would hold driving back with it. What takes long in it (the codecs, the
    copies) is done without that lock.
    """

    def __init__(self, sink: PictureSink, clock: Clock, budget: SharedBudget | None = None) -> None:
        """Take where pictures go, and what all threads together may take; `start` begins."""
        self._sink = sink
        self._clock = clock
        self._budget = SharedBudget() if budget is None else budget
        # By stream: its newest raw picture; under `_turn`.
        self._waiting: dict[str, _Waiting] = {}
        # Whose turn it is, and how large pictures are made; of the thread alone.
        self._turns = Turns()
        self._sizes: dict[str, PictureSize] = {}
        # By stream: the thread of one that waits for a detector; under `_turn`. It would hold up
        # all others here.
        self._apart: dict[str, PictureWorker] = {}
        # Guards what waits, and wakes the thread.
        self._turn = threading.Condition()
        self._ended = False  # Set once, under `_turn`.
        # A daemon: where nobody calls `close`, it keeps no process from ending.
        self._thread = threading.Thread(target=self._work_loop, name="talaia-pictures", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def offer_raw(self, stream: PictureStream, raw: object) -> None:
        """Take the newest raw picture of a stream; stamped now."""
        mono_ns = self._clock.monotonic_ns()
        # Before the lock: most pictures of a fast camera end here.
        if not stream.is_due(mono_ns):
            return
        if stream.is_blurred:
            self._thread_apart(stream).queue_raw(stream, raw, mono_ns // 1000)
        else:
            self.queue_raw(stream, raw, mono_ns // 1000)

    def queue_raw(self, stream: PictureStream, raw: object, mono_us: int) -> None:
        """Take a picture that is due, in place of the one of its stream that waits."""
        with self._turn:
            waiting = self._waiting.get(stream.address)
            if waiting is None:
                waiting = self._waiting[stream.address] = _Waiting(stream)
            # In its place, which one that is quick does not lose.
            waiting.stream, waiting.raw = stream, raw
            waiting.time_us, waiting.mono_us = self._clock.wall_ns() // 1000, mono_us
            waiting.lost += 1
            self._turn.notify()

    def _thread_apart(self, stream: PictureStream) -> PictureWorker:
        with self._turn:
            worker = self._apart.get(stream.address)
            if worker is None:
                worker = self._apart[stream.address] = PictureWorker(
                    self._sink, self._clock, self._budget
                )
                if not self._ended:
                    worker.start()
            return worker

    def _work_loop(self) -> None:
        while True:
            with self._turn:
                while not self._ended and (rest_s := self._rest_s()) != 0:
                    self._turn.wait(rest_s)
                # What still waits is dropped: nobody looks any more.
                if self._ended:
                    return
                next_one = self._waiting.pop(self._turns.choose(self._waiting))
            # Without the lock, so that pictures are taken while one is encoded.
            self._make_pictures(next_one)

    def _rest_s(self) -> float | None:
        """Give how long to wait at the most (s): None until a picture comes, 0 not at all."""
        if not self._waiting:
            return None
        return self._budget.rest_us(self._clock.monotonic_ns() // 1000) / 1e6

    def _make_pictures(self, waiting: _Waiting) -> None:
        stream, before_ns = waiting.stream, time.thread_time_ns()
        began_us = self._clock.monotonic_ns() // 1000
        size = self._sizes.setdefault(stream.address, PictureSize())
        stream.process_picture(
            waiting.raw, waiting.time_us, waiting.mono_us, self._sink, divisor=size.divisor
        )
        # Of this thread alone: what a detector takes beside it has a limit of its own.
        cpu_us = (time.thread_time_ns() - before_ns) // 1000
        room = self._budget.spend(began_us, cpu_us)
        self._turns.spend(stream.address, cpu_us)
        size.note_picture(began_us, cpu_us, lost=waiting.lost, room=room)

    def close(self) -> None:
        """End the thread, and those of streams that have one of their own."""
        with self._turn:
            self._ended = True
            self._turn.notify()
        for worker in self._apart.values():
            worker.close()
        if self._thread.is_alive():
            self._thread.join()
