"""A process that sees, for one detector: ``python -m talaia.objects.child``.

It is told by its input what to load (one line of JSON), then shown pictures (`HEAD` and the rows
of RGB), and answers each with one line of JSON. It ends when its input does.

A process of its own, because a detector's file is a program from somewhere else, run by a large
library: it may crash, hang, or eat memory, and whoever drives must not notice.
"""

from __future__ import annotations

import contextlib
import json
import os
import resource
import signal
import struct
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from talaia.objects.detection import LABEL_LETTERS
from talaia.objects.detector import Detector, OutputFormat, Setting
from talaia.objects.errors import DetectorError
from talaia.objects.face_detector import FaceDetector

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

__all__ = ["HEAD", "MOST_FILES", "MOST_MEMORY", "main"]

# Of a picture: rows, columns, and how sure a box is at the least.
HEAD = struct.Struct("<IId")
# Behind all that drives or records.
NICENESS = 10
# Bytes: NanoDet takes 0.1 GB; what takes more than this takes it from the robot.
MOST_MEMORY = 2 * 1024**3
# The model's own, the pipes and what a library opens as it starts.
MOST_FILES = 64
# Seconds. The kernel ends the process then, also when it hangs inside the library.
LONGEST_LOAD_S, LONGEST_LOOK_S = 120, 20


def main() -> None:
    """See until the input ends."""
    # Libraries may print: the answers' pipe is for answers.
    answers = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)
    # Before the file is loaded: loading alone takes the processor and the memory of a whole
    # detector.
    _lower_priority()
    source = os.fdopen(0, "rb", buffering=0)
    # No handler is set: the kernel's own action ends the process, which needs no Python to run.
    signal.alarm(LONGEST_LOAD_S)
    try:
        detector, classes = _load_network(json.loads(_read_line(source)))
    except Exception as error:  # noqa: BLE001 - said to whoever asked, whatever it is
        _write_answer(answers, problem=_problem_text(error))
        return
    # An empty answer: it is loaded, and pictures may come. No alarm runs while none does.
    _write_answer(answers)
    signal.alarm(0)
    while True:
        head = _read_exactly(source, HEAD.size)
        if head is None:
            return
        rows, columns, least = HEAD.unpack(head)
        body = _read_exactly(source, rows * columns * 3)
        if body is None:
            return
        # No copy; the array is over the buffer that was read into.
        picture = np.frombuffer(body, np.uint8).reshape(rows, columns, 3)
        # Only now, with the whole picture here: a slow writer is not the detector's fault.
        signal.alarm(LONGEST_LOOK_S)
        try:
            boxes = detector.detect_objects(picture, least)
        except Exception as error:  # noqa: BLE001 - as above
            _write_answer(answers, problem=_problem_text(error))
        else:
            _write_answer(
                answers, things=[(classes[box[0]], *map(float, box[1:])) for box in boxes]
            )
        signal.alarm(0)


def _lower_priority() -> None:
    """Give way to every other process, and be the first to go where memory is short."""
    os.nice(NICENESS)
    with contextlib.suppress(OSError, AttributeError):
        # Never takes the processor from another just because a picture has come.
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
    with contextlib.suppress(OSError):
        # 1000 is the highest: the kernel ends this process before any other. No right is needed.
        Path("/proc/self/oom_score_adj").write_text("1000", encoding="ascii")
    with contextlib.suppress(OSError, ValueError):
        # Data, not address space: libraries map far more than they use.
        resource.setrlimit(resource.RLIMIT_DATA, (MOST_MEMORY, MOST_MEMORY))
    with contextlib.suppress(OSError, ValueError):
        # A model may name further files of weights beside it.
        resource.setrlimit(resource.RLIMIT_NOFILE, (MOST_FILES, MOST_FILES))
    with contextlib.suppress(OSError, ValueError):
        # A core dump of a detector may be as large as its memory, and fill the robot's disk.
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    # Ctrl-C in a terminal reaches the whole group; whoever began this ends it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _load_network(job: dict[str, Any]) -> tuple[Detector | FaceDetector, Sequence[str]]:
    """Load what a job names.

    Raises:
        DetectorError: it is not there, or cannot be read.

    """
    file = job["file"]
    if not Path(file).is_file():
        raise DetectorError(f"{file}: there is no such file; {job['remedy']}")
    try:
        # Here, not at the top: without it the answer must still be a sentence.
        import onnxruntime
    except ImportError as error:
        raise DetectorError(f"{error}; install talaia[objects]") from error
    # 3 is errors: its warnings about a file's graph are of no use to who drives.
    onnxruntime.set_default_logger_severity(3)
    options = onnxruntime.SessionOptions()
    # One thread, which sleeps between pictures instead of spinning: the other cores are the
    # robot's.
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    try:
        # The processor alone, so that a detector behaves alike on every machine.
        session = onnxruntime.InferenceSession(file, options, providers=["CPUExecutionProvider"])
    except Exception as error:
        raise DetectorError(f"{file} cannot be loaded: {_problem_text(error)}") from error
    inputs = session.get_inputs()
    if len(inputs) != 1:
        raise DetectorError(f"{file} wants {len(inputs)} inputs; expected one, a picture")
    name = inputs[0].name

    def run(shown: NDArray[np.float32]) -> Sequence[NDArray[np.float32]]:
        try:
            found: Sequence[NDArray[np.float32]] = session.run(None, {name: shown})
        except Exception as error:
            raise DetectorError(f"{file} cannot be run: {_problem_text(error)}") from error
        return found

    classes = [label[:LABEL_LETTERS] for label in job["classes"]]
    if job["kind"] == "centerface":
        return FaceDetector(job["side"], run), classes
    setting = Setting(
        OutputFormat(job["kind"]),
        job["side"],
        tuple(job["mean"]),
        tuple(job["spread"]),
        job["blue_first"],
    )
    return Detector(setting, classes, run), classes


def _problem_text(error: BaseException) -> str:
    # One line, for an answer is one line; a library's message may be pages long.
    said = " ".join(str(error).split())[:1000]
    return said if isinstance(error, DetectorError) else f"{type(error).__name__}: {said}"


def _write_answer(answers: BinaryIO, **what: object) -> None:
    answers.write(json.dumps(what).encode() + b"\n")


def _read_line(source: BinaryIO) -> bytes:
    """Read up to a line's end and not a byte further."""
    said = b""
    while not said.endswith(b"\n"):
        # Byte by byte: the file is not buffered, and what follows the line is a picture's head.
        more = source.read(1)
        if not more:
            break
        said += more
    return said


def _read_exactly(source: BinaryIO, count: int) -> bytearray | None:
    """Read so many bytes; none when the input has ended."""
    data = bytearray(count)
    view, at = memoryview(data), 0
    while at < count:
        # Straight into place: a pipe gives a picture in many pieces.
        more = source.readinto(view[at:])  # type: ignore[attr-defined]
        if not more:
            return None
        at += more
    return data


if __name__ == "__main__":
    main()
    sys.exit(0)
