"""Decides which cameras are filmed, holds their last seconds, and writes films in its own thread.

The encoding thread only puts encoded pictures into a ring or a queue, under a lock that is held for
a moment.
"""

from __future__ import annotations

import threading
from collections import deque
from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.gateway.ports import Filming
from talaia.gateway.recording.film_ring import FilmRing
from talaia.gateway.recording.film_writer import CameraReel, FilmWriter
from talaia.gateway.recording.recording_store import NoRoom

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping

    from talaia.clock import Clock
    from talaia.gateway.ports import EventSink
    from talaia.gateway.recording.recording_store import RecordingStore
    from talaia.model.recording import Recording
    from talaia.wire.frames import PictureFrame

__all__ = ["FilmRecorder"]

_MB = 1_000_000
# s between two looks at ends and silences while nothing comes.
_LOOK_S = 0.25


class FilmRecorder:
    """Takes encoded pictures of cameras. Any thread may call it."""

    def __init__(
        self,
        *,
        plan: Recording,
        cameras: Collection[str],
        clips: Mapping[str, float],
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
            clips: cameras whose last seconds are held for clips of sightings, and how many (s).
            shelf: where films go.
            clock: monotonic for every decision; the pictures' own times for the record.
            events: told what is worth writing down.
            finished: told when a film waits for the hub; from the writing thread.
            changed: told when other cameras are filmed than before; from any thread.

        """
        self._plan = plan  # Of the description; another one makes another recorder.
        self._shelf = shelf  # Folder of films.
        self._clock = clock  # Monotonic for ends, wall only in the pictures.
        # Called without the lock, for it may ask `rolling_cameras` or `wanted_cameras`.
        self._changed = changed
        # Guards all that follows, and wakes the writing thread.
        self._wake = threading.Condition()
        self._writer = FilmWriter(
            plan=plan,
            shelf=shelf,
            clock=clock,
            events=events,
            lock=self._wake,
            finished=finished,
            changed=changed,
        )
        # By camera, whether or not it is being filmed now.
        self._reels: dict[str, CameraReel] = {}
        # Pictures that are to be written, in order, and their bytes.
        self._queue: deque[tuple[CameraReel, PictureFrame]] = deque()
        self._queued = 0
        # Everything is finished and nothing is begun any more.
        self._ending = False
        # When the disk's room was looked at last (monotonic).
        self._looked_ns = 0
        # Filmed with each recording.
        self._cameras = frozenset(cameras)
        # Held for clips, and how long (s).
        self._clips = dict(clips)
        self._thread = threading.Thread(target=self._write_loop, name="talaia-films", daemon=True)

    @property
    def problem(self) -> str:
        """Say why the last film could not be written; empty when it could."""
        return self._writer.problem

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

    def redescribe(self, cameras: Collection[str], clips: Mapping[str, float]) -> None:
        """Film other cameras with each recording, and hold others for clips, from now on."""
        with self._wake:
            self._cameras, self._clips = frozenset(cameras), dict(clips)
            for name, reel in self._reels.items():
                reel.ring.resize(round(self._held_s(name) * 1e6), self._ring_share())
        self._changed()

    # ── what is asked for ──

    def wanted_cameras(self) -> frozenset[str]:
        """Name the cameras that must be read for films."""
        with self._wake:
            held = {name for name in self._cameras | self._clips.keys() if self._held_s(name) > 0}
            return frozenset(held) | {name for name, reel in self._reels.items() if reel.rolling}

    def rolling_cameras(self) -> list[str]:
        """Name the cameras that are being filmed."""
        with self._wake:
            return sorted(name for name, reel in self._reels.items() if reel.rolling)

    def begin_film(self, who: str, why: str, for_s: float, stream: str = "") -> None:
        """Film one camera, or all that are filmed with each recording."""
        until_ns = self._clock.monotonic_ns() + round(for_s * SECOND)
        with self._wake:
            names = [stream] if stream else sorted(self._cameras)
            if self._ending or not names:
                return
            for name in names:
                self._start_reel(self._reel_of(name), who, why, until_ns)
            self._wake.notify()
        self._changed()

    def end_film(self, who: str, stream: str = "") -> None:
        """End what is filmed of one camera, or of all that are filmed with each recording."""
        with self._wake:
            for name in [stream] if stream else sorted(self._cameras):
                reel = self._reels.get(name)
                if reel is not None and reel.rolling:
                    reel.note = f"ended by {who}"
                    reel.until_ns = 0
            self._wake.notify()

    def _reel_of(self, stream: str) -> CameraReel:
        reel = self._reels.get(stream)
        if reel is None:
            ring = FilmRing(round(self._held_s(stream) * 1e6), self._ring_share())
            reel = self._reels[stream] = CameraReel(stream, ring)
        return reel

    def _held_s(self, stream: str) -> float:
        """Say how much of a camera is held while it is not filmed (s)."""
        filmed = self._plan.before if stream in self._cameras else 0.0
        return max(filmed, self._clips.get(stream, 0.0))

    def _ring_share(self) -> int:
        """Say how many bytes a camera may hold: all together take no more than is allowed."""
        return round(self._plan.ring_mb * _MB / max(1, len(self._cameras | self._clips.keys())))

    def _start_reel(self, reel: CameraReel, who: str, why: str, until_ns: int) -> None:
        if reel.rolling:
            if why not in reel.why:
                reel.why = f"{reel.why}; {why}"[:1000]
            # A second trigger prolongs; it never shortens what a first one asked for.
            reel.until_ns = max(reel.until_ns, until_ns)
            return
        reel.rolling, reel.until_ns, reel.failed = True, until_ns, False
        reel.why, reel.who, reel.note, reel.lost = why[:1000], who[:200], "", 0
        # First what is old enough goes, so that a film never begins earlier than described.
        reel.ring.trim_runs(self._clock.monotonic_ns() // 1000)
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
            held = self._held_s(stream) > 0
            if not held and (reel is None or not reel.rolling):
                return Filming.NO
            reel = reel or self._reel_of(stream)
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
            reel = self._reel_of(picture.stream)
            if not reel.rolling:
                if not reel.ring.add_picture(picture):
                    reel.wants_key = True
                return
            if self._queued + len(picture.data) > self._plan.ring_mb * _MB:
                # Counted in the note, so that nobody takes the jump for the scene's own.
                # The disk does not keep up; what follows makes no sense without this one.
                reel.lost += 1
                reel.wants_key = True
                return
            self._queue.append((reel, picture))
            self._queued += len(picture.data)
            self._wake.notify()

    # ── on the writing thread ──

    def _write_loop(self) -> None:
        while True:
            with self._wake:
                while not (self._queue or self._ending or self._is_active()):
                    self._wake.wait()
                # Woken by pictures as well as by time; the waiting releases the lock.
                if not self._queue and not self._ending:
                    self._wake.wait(_LOOK_S)
                queue, self._queue, self._queued = self._queue, deque(), 0
                over = self._end_expired()
                ending = self._ending
                # A copy: writing takes long and must not hold the lock.
                reels = list(self._reels.values())
            for reel, picture in queue:
                self._writer.write_picture(reel, picture)
            for reel in reels:
                if reel in over or ending:
                    self._writer.finish_film(reel)
                elif self._writer.is_silent(reel):
                    reel.note = reel.note or "the camera was silent"
                    self._writer.finish_film(reel)
            self._look_at_disk()
            if over:
                self._changed()
            if ending:
                return

    def _is_active(self) -> bool:
        return any(reel.rolling or reel.file is not None for reel in self._reels.values())

    def _end_expired(self) -> list[CameraReel]:
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
                self._writer.problem = str(error)
                for reel in self._reels.values():
                    if reel.rolling:
                        reel.until_ns, reel.note = 0, str(error)
