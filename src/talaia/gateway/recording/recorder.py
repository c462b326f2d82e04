"""Decides when raw topics are recorded, and writes them in a thread of its own.

The adapter's thread only puts messages into the ring or the queue, under a lock that is held for
a moment; files are made, compressed and finished elsewhere, so that driving never waits for them.
Long, because what begins, holds back and ends a recording is one state.
"""

from __future__ import annotations

import contextlib
import logging
import threading
from collections import deque
from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.gateway.recording.mcap_file import McapFileWriter
from talaia.gateway.recording.message_ring import OVERHEAD, MessageRing, RawMessage
from talaia.gateway.recording.recording_store import NoRoom, StoredRecording, new_id
from talaia.gateway.recording.standing_messages import StandingMessages
from talaia.model.topics import carries_pictures
from talaia.wire.frames import RecorderState

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.gateway.ports import EventSink
    from talaia.gateway.recording.recording_store import RecordingStore
    from talaia.model.recording import Recording, Trigger

__all__ = ["Recorder"]

log = logging.getLogger(__name__)
_MB = 1_000_000
# s; an end is noticed at most this late.
_LOOK_S = 0.25
# Messages that are written between two looks at the clock and the disk.
_AT_ONCE = 256


class Recorder:
    """A `RawSink`. Any thread may call it; what it tells is told from its own thread."""

    def __init__(
        self,
        *,
        plan: Recording,
        topics: tuple[str, ...],
        shelf: RecordingStore,
        clock: Clock,
        definition: Callable[[str], str],
        tell_state: Callable[[RecorderState], None],
        events: EventSink,
        finished: Callable[[], None],
        hides_pictures: bool = False,
    ) -> None:
        """Hold the last seconds of ``topics`` from `start` on.

        Args:
            plan: see `Recording`.
            topics: absolute names.
            shelf: where the files go.
            clock: monotonic for every decision, wall for the record.
            definition: gives the full text of a type; called from the recorder's thread.
            tell_state: told of each change.
            events: told what is worth writing down.
            finished: told when a recording waits for the hub.
            hides_pictures: a camera of the site is blurred, so that no messages are kept which may
                hold its pictures as they are.

        """
        self._plan = plan  # Of the description; another one makes another recorder.
        self.topics = frozenset(topics)
        self.hides_pictures = hides_pictures
        self._shelf = shelf  # Folder of recordings.
        self._clock = clock  # Monotonic for ends, wall for names.
        # Full text of a message type; may ask the robot, so on our thread.
        self._definition = definition
        self._send_state = tell_state  # Tells each change.
        self._events = events  # What is worth writing down.
        self._finished = finished  # Told when a file waits for the hub.
        # The last seconds, filled while no file is open.
        self._ring = MessageRing(round(plan.before * SECOND), round(plan.ring_mb * _MB))
        # What was said before them and still holds.
        self._standing = StandingMessages(round(plan.ring_mb * _MB / 4))
        self._changed = threading.Condition()  # Guards all that follows; wakes the thread.
        self._queue: deque[RawMessage] = deque()  # For the file, oldest first; only while `_open`.
        self._queued = 0  # Bytes in it, with overhead.
        self._lost = 0  # Messages that came while the queue was full; told in the note.
        # What is being recorded or finished; None while idle.
        self._kept: StoredRecording | None = None
        # Messages go into the file; not so while it is being finished.
        self._open = False
        # What came up while a file was being finished.
        self._next: tuple[str, str, float] | None = None
        self._until_ns = 0  # When it ends (monotonic ns); 0 ends it now.
        self._ending = False  # Nothing is begun any more.
        self._problem = ""  # Why the last one failed; cleared by the next beginning.
        self._thread = threading.Thread(
            target=self._write_loop, name="talaia-recorder", daemon=True
        )

    def start(self) -> None:
        """Begin to hold messages."""
        self._thread.start()

    def close(self) -> None:
        """Finish what is being recorded, and end."""
        with self._changed:
            self._ending = True
            self._until_ns = 0
            self._changed.notify()
        if self._thread.is_alive():
            self._thread.join()

    def offer(
        self,
        topic: str,
        type_name: str,
        data: bytes,
        time_ns: int,
        *,
        definition: str = "",
        encoding: str = "cdr",
    ) -> None:
        """See `RawSink.offer`."""
        if self.hides_pictures and carries_pictures(type_name, definition):
            return
        mono_ns = self._clock.monotonic_ns()
        raw = RawMessage(topic, type_name, time_ns, mono_ns, bytes(data), definition, encoding)
        with self._changed:
            self._standing.remember_message(raw)
            if not self._open:
                self._ring.add_message(raw)
                return
            if self._queued + len(data) > self._plan.ring_mb * _MB:
                # The disk does not keep up; memory is not to pay for that.
                self._lost += 1
                return
            self._queue.append(raw)
            self._queued += len(data) + OVERHEAD

    def begin_recording(self, who: str, why: str = "") -> None:
        """Record from the ring on, until `end_recording` or the longest time."""
        self._begin_kept(why or "asked for", who, self._plan.longest)

    def end_recording(self, who: str) -> None:
        """End what is being recorded."""
        with self._changed:
            if self._kept is not None and self._open:
                self._kept.note = _join_reasons(self._kept.note, f"ended by {who}")
                self._until_ns = 0
                self._changed.notify()

    def trigger_recording(self, trigger: Trigger, why: str, who: str = "") -> None:
        """Record around what has just happened, if the description wants that."""
        if trigger in self._plan.triggers:
            self._begin_kept(why, who, self._plan.after)

    def recorder_state(self) -> RecorderState:
        """Tell how it stands."""
        with self._changed:
            return self._state_locked()

    def _begin_kept(self, why: str, who: str, for_s: float) -> None:
        until_ns = self._clock.monotonic_ns() + round(for_s * SECOND)
        with self._changed:
            if self._ending:
                return
            if self._kept is not None and self._open:
                self._kept.why = _join_reasons(self._kept.why, why)
                self._until_ns = max(self._until_ns, until_ns)
                return
            if self._kept is not None:
                # The first that comes up while a file is finished; more would be for the same
                # moment.
                self._next = self._next or (why, who, for_s)
                return
            wall_ns = self._clock.wall_ns()
            self._ring.trim_old(self._clock.monotonic_ns())
            # STOP waits for this: no step of it may take longer when more is held.
            self._queued = self._ring.bytes
            self._queue = self._ring.drain_messages()
            self._lost = 0
            begin_ns = self._queue[0].time_ns if self._queue else wall_ns
            mono_ns = self._queue[0].mono_ns if self._queue else self._clock.monotonic_ns()
            # At the beginning, so that a recording is understood without what was before it.
            self._queue.extendleft(reversed(self._standing.messages_before(mono_ns, begin_ns)))
            self._kept = StoredRecording(
                id=new_id(wall_ns), why=why[:1000], who=who[:200], begin_us=begin_ns // 1000
            )
            self._until_ns = until_ns
            self._open = True
            self._problem = ""
            self._changed.notify()

    def _state_locked(self) -> RecorderState:
        kept = self._kept
        if kept is None:
            return RecorderState(on=False, problem=self._problem[:2000])
        remains_ns = max(0, self._until_ns - self._clock.monotonic_ns())
        return RecorderState(
            on=True,
            id=kept.id,
            why=kept.why,
            who=kept.who,
            since_us=kept.begin_us,
            ends_ms=remains_ns // 1_000_000,
        )

    # ── on the recorder's thread ──

    def _write_loop(self) -> None:
        while True:
            with self._changed:
                while self._kept is None and not self._ending:
                    self._changed.wait()
                kept = self._kept
                if kept is None:
                    return
            try:
                self._record_file(kept)
            except Exception as error:  # noqa: BLE001 - told, and the next one may go well
                self._handle_failure(kept, error)

    def _record_file(self, kept: StoredRecording) -> None:
        # Told before the disk is asked: a page should show that a press has counted.
        self._report_state()
        self._events.report_event("recording_started", f"{kept.id}: {kept.why}", who=kept.who)
        for gone in self._shelf.begin_recording(kept, round(self._plan.file_mb * _MB)):
            self._events.report_event(
                "recording_dropped", f"{gone.id}: it waited for the hub, and the disk is full"
            )
        file = McapFileWriter(self._shelf.part_path(kept.id), self._definition)
        try:
            note = self._fill_file(file)
            with self._changed:
                self._stop_filling()
                kept.messages, kept.topics = file.messages, file.topics
                kept.end_us = self._clock.wall_ns() // 1000
                if note:
                    kept.note = _join_reasons(kept.note, note)
                if self._lost:
                    lost = f"{self._lost} messages are missing: the disk did not keep up"
                    kept.note = _join_reasons(kept.note, lost)
            file.write_metadata(
                {"id": kept.id, "why": kept.why, "who": kept.who, "note": kept.note}
            )
            file.finish_file()
        except BaseException:
            file.drop_file()
            raise
        self._shelf.part_path(kept.id).rename(self._shelf.whole_path(kept.id))
        self._shelf.finish_recording(kept)
        self._finish_recording()
        size = f"{kept.messages} messages, {kept.size / _MB:.1f} MB"
        note = f"; {kept.note}" if kept.note else ""
        self._events.report_event(
            "recording_ended", f"{kept.id}: {size}{note}", who=kept.who, good=True
        )
        self._report_state()
        self._finished()

    def _fill_file(self, file: McapFileWriter) -> str:
        """Write until it is to end; give why it ended early, if it did."""
        most = self._plan.file_mb * _MB
        looked_ns = 0
        bad: dict[str, str] = {}
        while True:
            with self._changed:
                if not self._queue and self._until_ns > self._clock.monotonic_ns():
                    self._changed.wait(_LOOK_S)
                queue, self._queue, self._queued = self._queue, deque(), 0
                over = self._until_ns <= self._clock.monotonic_ns()
            for at, raw in enumerate(queue):
                # Told once for its type; each message of it would fill the log.
                if raw.type_name in bad:
                    continue
                try:
                    file.add_message(raw)
                # The disk's trouble ends this recording; a type's spoils only that type.
                except OSError:
                    raise
                except Exception as error:  # noqa: BLE001 - one type must not spoil the others
                    bad[raw.type_name] = str(error)
                    log.warning("%s cannot be recorded: %s", raw.topic, error)
                if at % _AT_ONCE == 0 and file.size > most:
                    return "it had the greatest size that the description allows"
            if over:
                return "; ".join(f"without {name}: {problem}" for name, problem in bad.items())
            now_ns = self._clock.monotonic_ns()
            if now_ns - looked_ns > SECOND:
                looked_ns = now_ns
                try:
                    self._shelf.check_room()
                except NoRoom as error:
                    return str(error)
            if file.size > most:
                return "it had the greatest size that the description allows"

    def _handle_failure(self, kept: StoredRecording, error: Exception) -> None:
        log.warning("the recording %s failed: %s", kept.id, error)
        with self._changed:
            self._stop_filling()
            self._problem = f"{kept.id}: {error}"
        self._finish_recording()
        with contextlib.suppress(OSError):
            self._shelf.remove(kept.id)
        self._events.report_event("recording_failed", f"{kept.id}: {error}", who=kept.who)
        self._report_state()

    def _stop_filling(self) -> None:
        """Take no more into the file; what is over goes back into the ring. Under the lock."""
        self._open = False
        # They came after the end, and may be the beginning of the next one.
        for raw in self._queue:
            self._ring.add_message(raw)
        self._queue, self._queued = deque(), 0

    def _finish_recording(self) -> None:
        """Let the next one begin, at once if something came up meanwhile."""
        with self._changed:
            self._kept = None
            again, self._next = self._next, None
        if again is not None:
            self._begin_kept(*again)

    def _report_state(self) -> None:
        self._send_state(self.recorder_state())


def _join_reasons(before: str, more: str) -> str:
    """Put words together once, and not without end."""
    if not before:
        return more[:1000]
    return before if more in before else f"{before}; {more}"[:1000]
