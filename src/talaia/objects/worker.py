"""Detectors that run beside this process, each in one of its own; see `child`. Event loop only.

A picture goes there over a pipe from a thread, so that the loop does not wait. One that ends, hangs
or says nonsense is begun anew, later each time it happens again; the loss is told once, and so is
the recovery.

Long, because a process, its thread and its fate are told together.
"""

from __future__ import annotations

import asyncio
import contextlib
import fcntl
import json
import logging
import os
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from talaia.model.coco_classes import COCO
from talaia.model.detection import ModelKind
from talaia.model.picture_models.picture_model import points_of
from talaia.objects.child import HEAD, LONGEST_LOAD_S, LONGEST_LOOK_S
from talaia.objects.detection import Detection
from talaia.objects.detector import NANODET
from talaia.objects.errors import DetectorError
from talaia.objects.face_detector import FACES
from talaia.objects.kinds.catalog import KINDS
from talaia.objects.providers import CPU

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from talaia.model.detection import ObjectModel
    from talaia.objects.kinds.catalog import Scene

__all__ = ["FACE_FILE", "FACE_REMEDY", "OWN_FILE", "Worker", "WorkerTimes", "face_model"]

_LOG = logging.getLogger(__name__)
# Made by tools/make_detector.py; in an installed package it is there.
OWN_FILE = Path(__file__).parent / "models" / "nanodet.onnx"
OWN_REMEDY = "create it: python tools/make_detector.py"
# The same of what finds faces, by tools/make_face_detector.py.
FACE_FILE = Path(__file__).parent / "models" / "centerface.onnx"
FACE_REMEDY = "create it: python tools/make_face_detector.py"
_T = TypeVar("_T")
# Names of models begin so that are CenterFace; no description can name one of its own like that.
_FACES_BEGIN = "faces:"
# The child ends itself before this; the rest is for a machine that is busy.
PATIENCE_S = LONGEST_LOAD_S + LONGEST_LOOK_S + 10.0
END_S = 1.0
LONGEST_WAIT_S = 60.0
# Larger pictures are shown with every second pixel, or fewer: no detector sees them finer.
MOST_PX = 2048
# What the pipe holds: a picture of 640 × 480 goes over in one piece.
PIPE = 1024 * 1024
# What a detector's process needs of our surroundings; secrets are not among it.
_SURROUNDINGS = ("PATH", "PYTHONPATH", "LD_LIBRARY_PATH", "LANG", "SYSTEMROOT")
_ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def face_model(side: int) -> str:
    """Name the model that finds faces on pictures shown with a longer side of ``side`` px."""
    return f"{_FACES_BEGIN}{side}"


class WorkerTimes(NamedTuple):
    """Times of a detector's process (s).

    Attributes:
        first_wait: before one that failed is begun anew; doubled with each failure.
        steady: one that has worked for so long is well again.

    """

    first_wait: float = 1.0
    steady: float = 10.0


USUAL = WorkerTimes()


class Worker:
    """Sees things on pictures."""

    def __init__(
        self,
        models: Mapping[str, ObjectModel],
        folder: Path,
        told: Callable[[str, str], None],
        times: WorkerTimes = USUAL,
        *,
        provider: str = CPU,
    ) -> None:
        """Begin nothing yet: a detector is loaded for its first picture.

        Args:
            models: detectors of one's own, by name; the empty name is NanoDet's.
            folder: where relative paths of theirs begin.
            told: takes a model's name and why it cannot see, once, and then once an empty text
                when it does again.
            times: of each detector's process.
            provider: what detectors run on, as `parse_provider` reads it.

        """
        # Part of each job; a process that cannot use it takes the processor and says so.
        self._provider = provider
        # Of each process; tests give shorter ones.
        self._times = times
        # As described now; `redescribe` compares with it.
        self._models = dict(models)
        # For relative paths of models; the package's own detector has an absolute one.
        self._folder = folder
        # Called on the event loop, on a change only: why it cannot see, or an empty text.
        self._told = told
        # Detectors that run or wait to be started again, by the model's name.
        self._running: dict[str, _Running] = {}
        # Tasks that end a detector; asyncio itself keeps only weak references to them.
        self._ending: set[asyncio.Task[None]] = set()

    def redescribe(self, models: Mapping[str, ObjectModel]) -> None:
        """Use these detectors from here on; those that are the same go on."""
        for name in list(self._running):
            # Those of the package, the empty name and faces, no description changes.
            if name and ":" not in name and models.get(name) != self._models.get(name):
                self._end_process(name)
        self._models = dict(models)

    def stop_idle(self, model: str) -> None:
        """End a detector that nobody needs any more; it begins anew for the next picture."""
        if model in self._running:
            self._end_process(model)

    async def detect_objects(
        self, model: str, rgb: NDArray[np.uint8], least: float
    ) -> list[Detection]:
        """Find things on a picture.

        Pictures for one detector take turns in the order in which they are given.

        Args:
            model: a name of the models', or empty, or of `face_model`.
            rgb: rows × columns × 3.
            least: what is less sure (0 to 1) is left out.

        Returns:
            The surest first; at most 100, and of faces 1 000.

        Raises:
            DetectorError: the detector cannot see now; of ``told`` the same is heard. While it
                waits to be begun anew this is raised at once.

        """
        return await self._ask_process(model, rgb, least, _read_boxes)

    async def read_scene(self, model: str, rgb: NDArray[np.uint8], least: float) -> Scene:
        """Let a model that tells no boxes say what it sees on a picture; as `detect_objects`.

        Args:
            model: a name of the models', of one of the kinds in `objects.kinds.catalog`.
            rgb: rows × columns × 3.
            least: what is less sure (0 to 1) is left out, where its kind knows such a thing.

        Raises:
            DetectorError: it cannot see now.

        """
        about = self._models.get(model)
        if about is None or about.kind not in KINDS:
            raise DetectorError(f"there is no model {model!r} that tells anything but boxes")
        return await self._ask_process(model, rgb, least, KINDS[about.kind].read_answer)

    async def _ask_process(
        self, model: str, rgb: NDArray[np.uint8], least: float, read: Callable[[dict[str, Any]], _T]
    ) -> _T:
        running = self._running.get(model)
        if running is None:
            running = self._running[model] = _Running(
                {**self._make_job(model), "provider": self._provider},
                partial(self._told, model),
                self._times,
            )
        return await running.ask_process(rgb, least, read)

    def _make_job(self, model: str) -> dict[str, Any]:
        if not model:
            setting: dict[str, Any] = {**NANODET._asdict(), "kind": NANODET.kind.value}
            return {**setting, "file": str(OWN_FILE), "remedy": OWN_REMEDY, "classes": COCO}
        if model.startswith(_FACES_BEGIN):
            side = int(model.removeprefix(_FACES_BEGIN))
            about_faces = {"kind": "centerface", "side": side, "classes": FACES}
            return {**about_faces, "file": str(FACE_FILE), "remedy": FACE_REMEDY}
        about = self._models.get(model)
        if about is None:
            raise DetectorError(f"there is no model {model!r}; describe it in object_models")
        return {
            "kind": about.kind.value,
            "side": about.side,
            "mean": about.mean,
            "spread": about.spread,
            "blue_first": about.blue_first,
            "classes": about.classes,
            "points": points_of(about) if about.kind is ModelKind.KEYPOINTS else (),
            "file": str(self._folder / about.file),
            "remedy": f"put it there, or correct object_models.{model}.file",
        }

    def _end_process(self, model: str) -> None:
        # Taken out first: a picture that comes now begins another process and waits for nobody.
        task = asyncio.ensure_future(self._running.pop(model).close())
        self._ending.add(task)
        task.add_done_callback(self._ending.discard)

    async def close(self) -> None:
        """End all detectors."""
        for name in list(self._running):
            self._end_process(name)
        await asyncio.gather(*self._ending, return_exceptions=True)


class _Running:
    """One detector: its process, its thread, and how it has fared."""

    def __init__(
        self, job: dict[str, Any], told: Callable[[str], None], times: WorkerTimes
    ) -> None:
        self._told = told
        self._times = times
        # Used by the thread below; the loop only kills it and sets `closed`.
        self._child = _Child(job)
        # One thread: the pipe has one writer, and an answer belongs to the picture before it.
        self._thread = ThreadPoolExecutor(1, "talaia-objects")
        # One picture at a time; asyncio's locks are fair, so pictures keep their order.
        self._turn = asyncio.Lock()
        # Why it cannot see now, as it was reported; empty while it works.
        self._why = ""
        # Failures in a row; the wait before the next start doubles with each.
        self._failures = 0
        # Monotonic time of the next start, and of the last failure (s).
        self._not_before = 0.0
        self._failed_at = 0.0
        # Set once by `close`; the failure that follows from it is no news.
        self._closed = False

    async def ask_process(
        self, rgb: NDArray[np.uint8], least: float, read: Callable[[dict[str, Any]], _T]
    ) -> _T:
        """See `Worker.detect_objects`; ``read`` makes of an answer what is wanted."""
        async with self._turn:
            # The turn may come after the end, for one who waited for it.
            if self._closed:
                raise DetectorError("the detector has been ended")
            if time.monotonic() < self._not_before:
                # At once, with the reason of before: who waits for a dead detector must not wait
                # for its start.
                raise DetectorError(self._why)
            loop = asyncio.get_running_loop()
            asked = loop.run_in_executor(self._thread, self._child.ask_blocking, rgb, least, read)
            # Killing the process is the only way to end a thread that waits in `read`.
            late = loop.call_later(PATIENCE_S, self._child.kill_process)
            try:
                found = await asked
            except DetectorError as error:
                self._fail_waiting(str(error))
                raise
            finally:
                late.cancel()
            self._mark_working()
            return found

    def _fail_waiting(self, why: str) -> None:
        if self._closed:
            return
        # Monotonic: a clock that is set must neither hold a start back for hours nor forget a
        # failure.
        self._failed_at = time.monotonic()
        wait = min(LONGEST_WAIT_S, self._times.first_wait * 2**self._failures)
        self._not_before = self._failed_at + wait
        # Bounded, for 2 to the power of it must stay a number.
        self._failures = min(self._failures + 1, 10)
        # Told once for a row of failures, though each may have another reason.
        if not self._why:
            self._told(why)
        self._why = why

    def _mark_working(self) -> None:
        # One good picture is no recovery: a process may die after every second one.
        if self._why and time.monotonic() - self._failed_at > self._times.steady:
            self._why, self._failures = "", 0
            self._told("")

    async def close(self) -> None:
        # Before the kill: a thread that is just starting a process sees it and ends that one, too.
        self._closed = self._child.closed = True
        self._child.kill_process()
        # Its read ends with the process; only then may another thread clear up after it.
        await asyncio.to_thread(self._thread.shutdown)
        await asyncio.to_thread(self._child.end_process)


class _Child:
    """The process. One thread asks and ends it; `kill_process` may be called from another."""

    def __init__(self, job: dict[str, Any]) -> None:
        # What to load; written to each new process as its first line.
        self._job = job
        # The process; none before the first picture and after it ended.
        self._process: subprocess.Popen[bytes] | None = None
        # Reads stderr, so that a library's warnings never fill the pipe and stop the process.
        self._listener: threading.Thread | None = None
        # Last lines of stderr, for the reason when it ends.
        self._words: deque[str] = deque(maxlen=20)
        self.closed = False

    def ask_blocking(
        self, rgb: NDArray[np.uint8], least: float, read: Callable[[dict[str, Any]], _T]
    ) -> _T:
        """Show a picture, and read the answer by ``read``; blocks.

        Raises:
            DetectorError: with why nothing can be seen. The process may be gone then, and is begun
                anew when asked again.

        """
        # Rounded up: every n-th pixel is enough, the detector scales to its own size anyway.
        by = -(-max(rgb.shape[:2]) // MOST_PX)
        shown = np.ascontiguousarray(rgb[::by, ::by], np.uint8)
        told = self._told_of(HEAD.pack(*shown.shape[:2], least), shown.data.cast("B"))
        try:
            return read(told)
        except (KeyError, ValueError, TypeError, IndexError) as error:
            self.end_process()
            raise DetectorError(f"invalid answer of the detector's process: {error!r}") from error

    def _told_of(self, *said: bytes | memoryview) -> dict[str, Any]:
        """Say something to the process and give its answer."""
        try:
            process = self._process or self._started_process()
            for line in said:
                _write_to_child(process, line)
            told = self._read_answer(process)
        except OSError as error:
            raise DetectorError(self._collect_exit()) from error
        # The detector says so itself; its process goes on.
        if "problem" in told:
            raise DetectorError(str(told["problem"]))
        return told

    def _started_process(self) -> subprocess.Popen[bytes]:
        # Not the whole environment: keys and tokens are none of the business of a file from
        # elsewhere.
        kept = {name: os.environ[name] for name in _SURROUNDINGS if name in os.environ}
        try:
            process = subprocess.Popen(
                [sys.executable, "-m", "talaia.objects.child"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                # Unbuffered: `write` tells how much the pipe took; `kill_process` leaves nothing
                # to flush.
                bufsize=0,
                env={**kept, **_ONE_THREAD},
            )
        except OSError as error:
            raise DetectorError(f"the process could not be started: {error}") from error
        self._process = process
        # `kill_process` may have come from the event loop while this thread started the process.
        if self.closed:
            process.kill()
        self._words.clear()
        self._listener = threading.Thread(
            target=self._listen_to_child, args=(process,), daemon=True
        )
        self._listener.start()
        with contextlib.suppress(OSError):
            # Refused where the system allows less; then a picture goes over in more pieces.
            fcntl.fcntl(process.stdin or 0, fcntl.F_SETPIPE_SZ, PIPE)
        _write_to_child(process, json.dumps(self._job).encode() + b"\n")
        told = self._read_answer(process)
        if "problem" in told:
            self.end_process()
            raise DetectorError(str(told["problem"]))
        if told.get("note"):
            _LOG.warning("objects are seen by the processor: %s", told["note"])
        return process

    def _read_answer(self, process: subprocess.Popen[bytes]) -> dict[str, Any]:
        assert process.stdout is not None  # noqa: S101 - told to mypy
        line = process.stdout.readline()
        # Half a line, or none: it ended while it answered.
        if not line.endswith(b"\n"):
            raise DetectorError(self._collect_exit())
        try:
            told = json.loads(line)
        except ValueError:
            told = None
        if not isinstance(told, dict):
            # A library that prints to standard output, say. What it meant nobody can know.
            self.end_process()
            raise DetectorError(f"the detector's process said {line[:60]!r} instead of an answer")
        return told

    def _listen_to_child(self, process: subprocess.Popen[bytes]) -> None:
        """Take what it and its libraries print, for one who wants to know why it ended."""
        assert process.stderr is not None  # noqa: S101 - told to mypy
        with contextlib.suppress(OSError, ValueError):
            for line in process.stderr:
                # Lines may hold whatever a library prints; they are cut, and only the last of them
                # kept.
                self._words.append(line.decode("utf-8", "replace").strip()[:300])

    def _collect_exit(self) -> str:
        """Say how it ended, and take it away."""
        # A negative code is the number of the signal that ended it.
        code = self.end_process()
        if code == -signal.SIGALRM:
            return f"the detector took longer than {LONGEST_LOOK_S} s and was ended"
        last = next((f": {word}" for word in reversed(self._words) if word), "")
        why = f"by signal {-code}" if code < 0 else f"with code {code}"
        return f"the detector's process ended {why}{last}"

    def kill_process(self) -> None:
        """End it at once; what waits for it hears so."""
        # Once into a local: the other thread may set the field to none between test and use.
        process = self._process
        if process is not None:
            process.kill()

    def end_process(self) -> int:
        """End it and take away what is left of it; blocks for a moment; gives how it ended."""
        # Cleared before anything can fail, so that the next picture begins another.
        process, self._process = self._process, None
        if process is None:
            return 0
        # What ends by itself is to be heard out.
        with contextlib.suppress(OSError):
            if process.stdin is not None:
                process.stdin.close()
        try:
            code = process.wait(END_S)
        except subprocess.TimeoutExpired:
            process.kill()
            code = process.wait()
        if self._listener is not None:
            # Its last lines say why; it ends at the pipe's end, unless a grandchild still holds
            # that.
            self._listener.join(END_S)
        for pipe in (process.stdout, process.stderr):
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()
        return code


def _read_boxes(answer: dict[str, Any]) -> list[Detection]:
    return [
        # From another process that may be broken: each number is made one and kept within the
        # picture.
        Detection(str(box[0]), *(min(max(float(one), 0.0), 1.0) for one in box[1:]))
        for box in answer["things"]
    ]


def _write_to_child(process: subprocess.Popen[bytes], data: bytes | memoryview) -> None:
    assert process.stdin is not None  # noqa: S101 - told to mypy
    left = memoryview(data)
    while left:
        # A pipe takes what it has room for; the rest is written again.
        left = left[process.stdin.write(left) :]
