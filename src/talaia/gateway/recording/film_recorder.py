"""Decides which cameras are filmed, holds their last seconds, and writes films in its own thread.

The encoding thread only puts encoded pictures into a ring or a queue, under a lock that is held for
a moment. What is written is cut into files wherever a film would not tell the truth: where the
camera was silent, where the clock was put back, and where the picture's size changed.

Long, because a film's whole life is told here: asked for, held, written, ended, failed.
"""

from __future__ import annotations

import contextlib
import logging
import threading
from collections import deque
from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.gateway.ports import Filming
from talaia.gateway.recording.film_file import FilmFile
from talaia.gateway.recording.film_ring import FilmRing
from talaia.gateway.recording.recording_store import NoRoom, StoredRecording, new_id

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from talaia.clock import Clock
    from talaia.gateway.ports import EventSink
    from talaia.gateway.recording.recording_store import RecordingStore
    from talaia.model.recording import Recording
    from talaia.wire.frames import PictureFrame

__all__ = ["FilmRecorder"]

log = logging.getLogger(__name__)
_MB = 1_000_000
_LOOK_S = 0.25
# A camera that is silent for so long has ended its film, so that none shows it standing still; one
# that is slow may be silent for so many times its last interval (µs).
_SILENT_US, _INTERVALS, _LONGEST_US = 3_000_000, 3, 60_000_000


class _Reel:
    """One camera: what is held of it, and what is being written."""

    def __init__(self, stream: str, ring: FilmRing) -> None:
        self.stream = stream
        self.ring = ring
        # Decided under the lock.
        self.rolling = False
        self.until_ns = 0
        self.why = self.who = self.note = ""
        self.wants_key = True
        self.asked_ns = self.asked_us = 0
        self.lost = 0
        # Of the writing thread alone.
        self.file: FilmFile | None = None
        self.kept: StoredRecording | None = None
        self.wrote_ns = 0
        self.seen_us = 0
        self.silent_us = _SILENT_US
        self.failed = False


class FilmRecorder:
    """Takes encoded pictures of cameras. Any thread may call it."""

    def __init__(
        self,
        *,
        plan: Recording,
        cameras: Collection[str],
        shelf: RecordingStore,
        clock: Clock,
        events: EventSink,
        finished: Callable[[], None],
        changed: Callable[[], None],
    ) -> None:
        """Hold the last seconds of ``cameras``.

        Args:
            plan: see `Recording`.
            cameras: filmed with each recording (``device/stream``).
            shelf: where films go.
            clock: monotonic for every decision; the pictures' own times for the record.
            events: told what is worth writing down.
            finished: told when a film waits for the hub; from the writing thread.
            changed: told when other cameras are filmed than before; from any thread.

        """
        self._plan = plan
        self._shelf = shelf
        self._clock = clock
        self._events = events
        self._finished = finished
        self._told = changed
        self._wake = threading.Condition()
        self._reels: dict[str, _Reel] = {}
        self._queue: deque[tuple[_Reel, PictureFrame]] = deque()
        self._queued = 0
        self._ending = False
        self._looked_ns = 0
        self.problem = ""
        self._cameras = frozenset(cameras)
        self._thread = threading.Thread(target=self._run, name="talaia-films", daemon=True)

    def start(self) -> None:
        """Begin to write what is asked for."""
        self._thread.start()

    def close(self) -> None:
        """Finish what is being filmed, and end."""
        with self._wake:
            self._ending = True
            self._wake.notify()
        if self._thread.is_alive():
            self._thread.join()

    def redescribe(self, cameras: Collection[str]) -> None:
        """Film other cameras with each recording from now on."""
        with self._wake:
            self._cameras = frozenset(cameras)
        self._told()

    # ── what is asked for ──

    def wanted(self) -> frozenset[str]:
        """Name the cameras that must be read for films."""
        with self._wake:
            held = self._cameras if self._plan.before > 0 else frozenset()
            return held | {name for name, reel in self._reels.items() if reel.rolling}

    def rolling(self) -> list[str]:
        """Name the cameras that are being filmed."""
        with self._wake:
            return sorted(name for name, reel in self._reels.items() if reel.rolling)

    def begin(self, who: str, why: str, for_s: float, stream: str = "") -> None:
        """Film one camera, or all that are filmed with each recording."""
        until_ns = self._clock.monotonic_ns() + round(for_s * SECOND)
        with self._wake:
            names = [stream] if stream else sorted(self._cameras)
            if self._ending or not names:
                return
            for name in names:
                self._roll(self._reel(name), who, why, until_ns)
            self._wake.notify()
        self._told()

    def end(self, who: str, stream: str = "") -> None:
        """End what is filmed of one camera, or of all that are filmed with each recording."""
        with self._wake:
            for name in [stream] if stream else sorted(self._cameras):
                reel = self._reels.get(name)
                if reel is not None and reel.rolling:
                    reel.note = f"ended by {who}"
                    reel.until_ns = 0
            self._wake.notify()

    def _reel(self, stream: str) -> _Reel:
        reel = self._reels.get(stream)
        if reel is None:
            # All cameras together take no more than is allowed.
            share = round(self._plan.ring_mb * _MB / max(1, len(self._cameras)))
            ring = FilmRing(round(self._plan.before * 1e6), share)
            reel = self._reels[stream] = _Reel(stream, ring)
        return reel

    def _roll(self, reel: _Reel, who: str, why: str, until_ns: int) -> None:
        if reel.rolling:
            if why not in reel.why:
                reel.why = f"{reel.why}; {why}"[:1000]
            reel.until_ns = max(reel.until_ns, until_ns)
            return
        reel.rolling, reel.until_ns, reel.failed = True, until_ns, False
        reel.why, reel.who, reel.note, reel.lost = why[:1000], who[:200], "", 0
        reel.ring.trim(self._clock.monotonic_ns() // 1000)
        held = reel.ring.drain_pictures()
        reel.wants_key = not held
        for picture in held:
            self._queue.append((reel, picture))
            self._queued += len(picture.data)

    # ── for the encoding threads ──

    def filming(self, stream: str, time_us: int) -> Filming:
        """Tell whether a camera's next picture is wanted, and whether it must need none before it.

        Args:
            stream: the camera (``device/stream``).
            time_us: when the picture came (wall, UTC).

        """
        with self._wake:
            reel = self._reels.get(stream)
            held = stream in self._cameras and self._plan.before > 0
            if not held and (reel is None or not reel.rolling):
                return Filming.NO
            reel = reel or self._reel(stream)
            now_ns = self._clock.monotonic_ns()
            # Another film begins after a silence and with a clock that was put back: with the
            # very first picture, for without its beginning all until the next one were lost.
            silent = now_ns - reel.asked_ns > reel.silent_us * 1000
            anew = reel.wants_key or silent or time_us <= reel.asked_us
            reel.wants_key, reel.asked_ns, reel.asked_us = False, now_ns, time_us
            return Filming.ANEW if anew else Filming.ON

    def add_picture(self, picture: PictureFrame) -> None:
        """Take the next picture of a camera's film."""
        with self._wake:
            reel = self._reel(picture.stream)
            if not reel.rolling:
                if not reel.ring.add(picture):
                    reel.wants_key = True
                return
            if self._queued + len(picture.data) > self._plan.ring_mb * _MB:
                # The disk does not keep up; what follows makes no sense without this one.
                reel.lost += 1
                reel.wants_key = True
                return
            self._queue.append((reel, picture))
            self._queued += len(picture.data)
            self._wake.notify()

    # ── on the writing thread ──

    def _run(self) -> None:
        while True:
            with self._wake:
                while not (self._queue or self._ending or self._active()):
                    self._wake.wait()
                if not self._queue and not self._ending:
                    self._wake.wait(_LOOK_S)
                queue, self._queue, self._queued = self._queue, deque(), 0
                over = self._over()
                ending = self._ending
                reels = list(self._reels.values())
            for reel, picture in queue:
                self._guard(reel, self._write_picture, picture)
            for reel in reels:
                if reel in over or ending:
                    self._guard(reel, self._finish)
                elif self._is_silent(reel):
                    reel.note = reel.note or "the camera was silent"
                    self._guard(reel, self._finish)
            self._look_at_disk()
            if over:
                self._told()
            if ending:
                return

    def _active(self) -> bool:
        return any(reel.rolling or reel.file is not None for reel in self._reels.values())

    def _over(self) -> list[_Reel]:
        """End what has lasted long enough. Under the lock."""
        now_ns = self._clock.monotonic_ns()
        over = [
            reel
            for reel in self._reels.values()
            if reel.rolling and (self._ending or reel.until_ns <= now_ns)
        ]
        for reel in over:
            reel.rolling, reel.wants_key = False, True
        return over

    def _is_silent(self, reel: _Reel) -> bool:
        silent_ns = self._clock.monotonic_ns() - reel.wrote_ns
        return reel.file is not None and silent_ns > reel.silent_us * 1000

    def _look_at_disk(self) -> None:
        """End all films while there is still room to finish them."""
        now_ns = self._clock.monotonic_ns()
        if now_ns - self._looked_ns < SECOND or not any(
            reel.file is not None for reel in self._reels.values()
        ):
            return
        self._looked_ns = now_ns
        try:
            self._shelf.check_room()
        except NoRoom as error:
            with self._wake:
                self.problem = str(error)
                for reel in self._reels.values():
                    if reel.rolling:
                        reel.until_ns, reel.note = 0, str(error)

    def _guard(self, reel: _Reel, work: Callable[..., None], *arguments: PictureFrame) -> None:
        """Do a step of one film; what goes wrong with it harms no other."""
        try:
            work(reel, *arguments)
        except Exception as error:  # noqa: BLE001 - told once, and the next film may go well
            self._fail(reel, error)

    def _write_picture(self, reel: _Reel, picture: PictureFrame) -> None:
        if reel.failed:
            return
        interval_us, reel.seen_us = picture.time_us - reel.seen_us, picture.time_us
        silent = interval_us > reel.silent_us
        reel.silent_us = min(max(_SILENT_US, _INTERVALS * interval_us), _LONGEST_US)
        file = reel.file
        full = file is not None and file.size > self._plan.file_mb * _MB
        cut = silent or (file is not None and not file.fits(picture)) or (full and picture.key)
        if not picture.key and (full or cut or file is None):
            # Before anything that takes a while: pictures come meanwhile.
            with self._wake:
                reel.wants_key = True
        if cut:
            self._finish(reel)
        if reel.file is not None:
            reel.file.add(picture)
        elif picture.key:
            self._open(reel, picture)
        reel.wrote_ns = self._clock.monotonic_ns()

    def _open(self, reel: _Reel, first: PictureFrame) -> None:
        with self._wake:
            why, who = reel.why, reel.who
        kept = StoredRecording(
            id=new_id(first.time_us * 1000),
            why=why,
            who=who,
            begin_us=first.time_us,
            stream=reel.stream,
        )
        for gone in self._shelf.begin(kept, round(self._plan.file_mb * _MB)):
            self._events.report_event(
                "recording_dropped", f"{gone.id}: it waited for the hub, and the disk is full"
            )
        reel.kept = kept
        reel.file = FilmFile(self._shelf.part(kept.id), first)
        self.problem = ""
        device = reel.stream.split("/", 1)[0]
        self._events.report_event(
            "recording_started", f"film of {reel.stream}: {why}", who=who, device=device
        )
        self._told()

    def _finish(self, reel: _Reel) -> None:
        file, kept = reel.file, reel.kept
        if file is None or kept is None:
            return
        with self._wake:
            kept.why = reel.why
            note = [reel.note] if reel.note else []
            if reel.lost:
                note.append(f"{reel.lost} pictures are missing: the disk did not keep up")
            reel.note, reel.lost = "", 0
        kept.note = "; ".join(note)
        kept.messages, kept.end_us = file.pictures, file.end_us
        part = self._shelf.part(kept.id)
        file.finish(part, self._shelf.whole(kept.id))
        reel.file = reel.kept = None
        part.unlink(missing_ok=True)
        self._shelf.finish(kept)
        said = f"film of {reel.stream}: {kept.messages} pictures, {kept.size / _MB:.1f} MB"
        self._events.report_event(
            "recording_ended",
            f"{said}{'; ' if note else ''}{kept.note}",
            who=kept.who,
            device=reel.stream.split("/", 1)[0],
            good=True,
        )
        self._finished()

    def _fail(self, reel: _Reel, error: Exception) -> None:
        """End a film that cannot be written. The next start makes whole what the disk has of it."""
        log.warning("the film of %s failed: %s", reel.stream, error)
        file, kept = reel.file, reel.kept
        reel.file = reel.kept = None
        reel.failed = True
        with self._wake:
            reel.rolling, reel.wants_key = False, True
            self.problem = f"{reel.stream}: {error}"[:2000]
        if file is not None:
            file.drop()
        if kept is not None:
            with contextlib.suppress(OSError):
                self._shelf.whole(kept.id).unlink(missing_ok=True)
        self._events.report_event(
            "recording_failed",
            f"film of {reel.stream}: {error}",
            who=reel.who,
            device=reel.stream.split("/", 1)[0],
        )
        self._told()
