"""Writes the films of cameras, each in files that tell the truth. On the writing thread alone.

A film is cut into files wherever it would not tell the truth: where the camera was silent, where
the clock was put back, and where the picture's size changed.
"""

from __future__ import annotations

import contextlib
import logging
from typing import TYPE_CHECKING

from talaia.gateway.recording.film_file import FilmFile
from talaia.gateway.recording.recording_store import StoredRecording, new_id

if TYPE_CHECKING:
    import threading
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.gateway.ports import EventSink
    from talaia.gateway.recording.film_ring import FilmRing
    from talaia.gateway.recording.recording_store import RecordingStore
    from talaia.model.recording import Recording
    from talaia.wire.frames import PictureFrame

__all__ = ["CameraReel", "FilmWriter"]

log = logging.getLogger(__name__)
_MB = 1_000_000
# A camera that is silent for so long has ended its film, so that none shows it standing still; one
# that is slow may be silent for so many times its last interval (µs).
_SILENT_US, _INTERVALS, _LONGEST_US = 3_000_000, 3, 60_000_000


class CameraReel:
    """One camera: what is held of it, and what is being written.

    Attributes:
        stream: the camera (``device/stream``).
        ring: its last seconds.

    """

    def __init__(self, stream: str, ring: FilmRing) -> None:
        """Hold pictures only."""
        self.stream = stream
        self.ring = ring
        # These change under the lock alone. Whether it is filmed, and until when (monotonic):
        self.rolling = False
        self.until_ns = 0
        # Of the film under way: why, for whom, and how it came to end.
        self.why = self.who = self.note = ""
        # The next picture must need none before it.
        self.wants_key = True
        # When a picture was last asked for (monotonic; wall, of the picture itself).
        self.asked_ns = self.asked_us = 0
        # Pictures that the disk was too slow for.
        self.lost = 0
        # These belong to the writing thread alone. The file under way, and its place on the shelf:
        self.file: FilmFile | None = None
        self.kept: StoredRecording | None = None
        # When the last picture was written (monotonic), and when it came (wall).
        self.wrote_ns = 0
        self.seen_us = 0
        # After so long without a picture the camera counts as silent (µs).
        self.silent_us = _SILENT_US
        # Nothing more is written of this film; the next one is tried again.
        self.failed = False


class FilmWriter:
    """Opens, writes and finishes the files of films.

    Attributes:
        problem: why the last film could not be written; empty when it could.

    """

    def __init__(
        self,
        *,
        plan: Recording,
        shelf: RecordingStore,
        clock: Clock,
        events: EventSink,
        lock: threading.Condition,
        finished: Callable[[], None],
        changed: Callable[[], None],
    ) -> None:
        """Write nothing yet.

        Args:
            plan: see `Recording`.
            shelf: where films go.
            clock: monotonic.
            events: told what is worth writing down.
            lock: held while what others decide of a reel is read or changed.
            finished: told when a film waits for the hub.
            changed: told when a film begins or fails.

        """
        self._plan = plan  # Sizes and times of the description.
        self._shelf = shelf  # Folder of films.
        self._clock = clock  # Monotonic; silence is judged by it.
        self._events = events  # Told of each film's beginning and end.
        self._lock = lock  # The recorder's; held for what both threads touch.
        self._finished = finished  # Called after each film that is whole.
        self._changed = changed  # Called when a film begins or fails.
        self.problem = ""

    def write_picture(self, reel: CameraReel, picture: PictureFrame) -> None:
        """Write the next picture of a film; what goes wrong with it harms no other film."""
        try:
            self._write_picture(reel, picture)
        except Exception as error:  # noqa: BLE001 - told once, and the next film may go well
            self._fail_film(reel, error)

    def finish_film(self, reel: CameraReel) -> None:
        """End the file that is being written of a camera, if there is one."""
        try:
            self._finish_kept(reel)
        except Exception as error:  # noqa: BLE001 - told once, and the next film may go well
            self._fail_film(reel, error)

    def is_silent(self, reel: CameraReel) -> bool:
        """Tell whether a camera that is being written has sent nothing for too long."""
        silent_ns = self._clock.monotonic_ns() - reel.wrote_ns
        return reel.file is not None and silent_ns > reel.silent_us * 1000

    def _write_picture(self, reel: CameraReel, picture: PictureFrame) -> None:
        if reel.failed:
            return
        interval_us, reel.seen_us = picture.time_us - reel.seen_us, picture.time_us
        silent = interval_us > reel.silent_us
        # Three of its last intervals: a camera of one picture in 5 s is not silent after 4.
        reel.silent_us = min(max(_SILENT_US, _INTERVALS * interval_us), _LONGEST_US)
        file = reel.file
        full = file is not None and file.size > self._plan.file_mb * _MB
        cut = (
            silent or (file is not None and not file.may_follow(picture)) or (full and picture.key)
        )
        if not picture.key and (full or cut or file is None):
            # Before anything that takes a while: pictures come meanwhile.
            with self._lock:
                reel.wants_key = True
        if cut:
            self._finish_kept(reel)
        if reel.file is not None:
            reel.file.add_picture(picture)
        elif picture.key:
            self._open_film(reel, picture)
        reel.wrote_ns = self._clock.monotonic_ns()

    def _open_film(self, reel: CameraReel, first: PictureFrame) -> None:
        with self._lock:
            why, who = reel.why, reel.who
        kept = StoredRecording(
            id=new_id(first.time_us * 1000),
            # The first picture's time, not ours: it may have waited in the ring.
            why=why,
            who=who,
            begin_us=first.time_us,
            stream=reel.stream,
        )
        for gone in self._shelf.begin_recording(kept, round(self._plan.file_mb * _MB)):
            self._events.report_event(
                "recording_dropped", f"{gone.id}: it waited for the hub, and the disk is full"
            )
        reel.kept = kept
        reel.file = FilmFile(self._shelf.part_path(kept.id), first)
        self.problem = ""
        device = reel.stream.split("/", 1)[0]
        self._events.report_event(
            "recording_started", f"film of {reel.stream}: {why}", who=who, device=device
        )
        self._changed()

    def _finish_kept(self, reel: CameraReel) -> None:
        file, kept = reel.file, reel.kept
        if file is None or kept is None:
            return
        with self._lock:
            kept.why = reel.why
            note = [reel.note] if reel.note else []
            if reel.lost:
                note.append(f"{reel.lost} pictures are missing: the disk did not keep up")
            reel.note, reel.lost = "", 0
        kept.note = "; ".join(note)
        kept.messages, kept.end_us = file.pictures, file.end_us
        # `part` stays until the whole file is there: a kill in between loses nothing.
        part = self._shelf.part_path(kept.id)
        file.finish_file(part, self._shelf.whole_path(kept.id))
        reel.file = reel.kept = None
        part.unlink(missing_ok=True)
        self._shelf.finish_recording(kept)
        said = f"film of {reel.stream}: {kept.messages} pictures, {kept.size / _MB:.1f} MB"
        self._events.report_event(
            "recording_ended",
            f"{said}{'; ' if note else ''}{kept.note}",
            who=kept.who,
            device=reel.stream.split("/", 1)[0],
            good=True,
        )
        self._finished()

    def _fail_film(self, reel: CameraReel, error: Exception) -> None:
        """End a film that cannot be written. The next start makes whole what the disk has of it."""
        log.warning("the film of %s failed: %s", reel.stream, error)
        file, kept = reel.file, reel.kept
        reel.file = reel.kept = None
        reel.failed = True
        with self._lock:
            reel.rolling, reel.wants_key = False, True
            self.problem = f"{reel.stream}: {error}"[:2000]
        if file is not None:
            file.drop_file()
        if kept is not None:
            # The part stays: the next start makes whole what is readable of it.
            with contextlib.suppress(OSError):
                self._shelf.whole_path(kept.id).unlink(missing_ok=True)
        self._events.report_event(
            "recording_failed",
            f"film of {reel.stream}: {error}",
            who=reel.who,
            device=reel.stream.split("/", 1)[0],
        )
        self._changed()
