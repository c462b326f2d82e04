"""The thread that encodes pictures; of those that wait, the newest of each camera wins."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.gateway.ports import PictureSink
    from talaia.gateway.video.camera import PictureStream

__all__ = ["PictureWorker"]


class PictureWorker:
    """The encoding thread. At most one raw picture of each stream waits.

    It has no lower priority than the thread that drives: a thread that is put back while it holds
    the interpreter's lock would hold driving back with it. What takes long in it (the codecs, the
    copies) is done without that lock.
    """

    def __init__(self, sink: PictureSink, clock: Clock) -> None:
        """Take where pictures go; `start` begins."""
        self._sink = sink
        self._clock = clock
        # By stream: its newest raw picture with wall and monotonic time (µs); under `_turn`.
        self._waiting: dict[str, tuple[PictureStream, object, int, int]] = {}
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
            # Out and in again: it goes to the end of the row, so a fast camera holds up no other.
            self._waiting.pop(stream.address, None)
            self._waiting[stream.address] = (stream, raw, self._clock.wall_ns() // 1000, mono_us)
            self._turn.notify()

    def _thread_apart(self, stream: PictureStream) -> PictureWorker:
        with self._turn:
            worker = self._apart.get(stream.address)
            if worker is None:
                worker = self._apart[stream.address] = PictureWorker(self._sink, self._clock)
                if not self._ended:
                    worker.start()
            return worker

    def _work_loop(self) -> None:
        while True:
            with self._turn:
                while not self._waiting and not self._ended:
                    self._turn.wait()
                # What still waits is dropped: nobody looks any more.
                if self._ended:
                    return
                stream, raw, time_us, mono_us = self._waiting.pop(next(iter(self._waiting)))
            # Without the lock, so that pictures are taken while one is encoded.
            stream.process_picture(raw, time_us, mono_us, self._sink)

    def close(self) -> None:
        """End the thread, and those of streams that have one of their own."""
        with self._turn:
            self._ended = True
            self._turn.notify()
        for worker in self._apart.values():
            worker.close()
        if self._thread.is_alive():
            self._thread.join()
