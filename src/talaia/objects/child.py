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

from talaia.model.detection import ModelKind
from talaia.objects.detection import LABEL_LETTERS
from talaia.objects.detector import Detector, OutputFormat, Setting
from talaia.objects.errors import DetectorError
from talaia.objects.face_detector import FaceDetector
from talaia.objects.kinds.catalog import KINDS
from talaia.objects.kinds.picture_input import InputSetting
from talaia.objects.network import error_text, open_network
from talaia.objects.providers import CPU, parse_provider

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    # From a picture, and how sure something must be at the least, to the answer.
    Look = Callable[[NDArray[np.uint8], float], dict[str, object]]

__all__ = ["HEAD", "MOST_FILES", "MOST_MEMORY", "main"]

# Of a picture: rows, columns, and how sure a box is at the least.
HEAD = struct.Struct("<IId")
# Behind all that drives or records.
NICENESS = 10
# Bytes: NanoDet takes 0.1 GB; what takes more than this takes it from the robot.
MOST_MEMORY = 2 * 1024**3
# The model's own, the pipes and what a library opens as it starts.
MOST_FILES = 64
# The same for one that runs on a device: its library maps the device's memory and opens its files.
DEVICE_MEMORY, DEVICE_FILES = 16 * 1024**3, 1024
# Seconds. The kernel ends the process then, also when it hangs inside the library.
LONGEST_LOAD_S, LONGEST_LOOK_S = 120, 20


def main() -> None:
    """See until the input ends."""
    # Libraries may print: the answers' pipe is for answers.
    answers = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)
    source = os.fdopen(0, "rb", buffering=0)
    line = _read_line(source)
    # Before the file is loaded: loading alone takes the processor and the memory of a whole
    # detector.
    _lower_priority(on_device=_runs_on_device(line))
    # No handler is set: the kernel's own action ends the process, which needs no Python to run.
    signal.alarm(LONGEST_LOAD_S)
    try:
        read_picture, note = _load_network(json.loads(line))
    except Exception as error:  # noqa: BLE001 - said to whoever asked, whatever it is
        _write_answer(answers, problem=error_text(error))
        return
    # It is loaded, and pictures may come. No alarm runs while none does.
    _write_answer(answers, note=note)
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
            answer = read_picture(picture, least)
        except Exception as error:  # noqa: BLE001 - as above
            answer = {"problem": error_text(error)}
        _write_answer(answers, **answer)
        signal.alarm(0)


def _runs_on_device(line: bytes) -> bool:
    """Tell whether a job's detector is to run on a device with a library of its own."""
    try:
        return not parse_provider(json.loads(line).get("provider", CPU)).on_processor
    except (ValueError, AttributeError, DetectorError):
        return False


def _lower_priority(*, on_device: bool) -> None:
    """Give way to every other process, and be the first to go where memory is short."""
    memory, files = (DEVICE_MEMORY, DEVICE_FILES) if on_device else (MOST_MEMORY, MOST_FILES)
    os.nice(NICENESS)
    with contextlib.suppress(OSError, AttributeError):
        # Never takes the processor from another just because a picture has come.
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
    with contextlib.suppress(OSError):
        # 1000 is the highest: the kernel ends this process before any other. No right is needed.
        Path("/proc/self/oom_score_adj").write_text("1000", encoding="ascii")
    with contextlib.suppress(OSError, ValueError):
        # Data, not address space: libraries map far more than they use.
        resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
    with contextlib.suppress(OSError, ValueError):
        # A model may name further files of weights beside it.
        resource.setrlimit(resource.RLIMIT_NOFILE, (files, files))
    with contextlib.suppress(OSError, ValueError):
        # A core dump of a detector may be as large as its memory, and fill the robot's disk.
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    # Ctrl-C in a terminal reaches the whole group; whoever began this ends it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _load_network(job: dict[str, Any]) -> tuple[Look, str]:
    """Load what a job names; with why it does not run on what it should, if it does not.

    Raises:
        DetectorError: it is not there, or cannot be read.

    """
    file = job["file"]
    if not Path(file).is_file():
        raise DetectorError(f"{file}: there is no such file; {job['remedy']}")
    run, note = _open_on(file, job.get("provider", CPU))
    classes = [label[:LABEL_LETTERS] for label in job["classes"]]
    if job["kind"] == "centerface":
        return _tell_boxes(FaceDetector(job["side"], run), classes), note
    setting = InputSetting(job["side"], tuple(job["mean"]), tuple(job["spread"]), job["blue_first"])
    kind = ModelKind(job["kind"])
    if kind.tells_boxes:
        detector = Detector(Setting(OutputFormat(kind), *setting), classes, run)
        return _tell_boxes(detector, classes), note
    return KINDS[kind].make_reader(setting, job["points"] or classes, run).read_picture, note


def _tell_boxes(detector: Detector | FaceDetector, classes: Sequence[str]) -> Look:
    def read_picture(picture: NDArray[np.uint8], least: float) -> dict[str, object]:
        boxes = detector.detect_objects(picture, least)
        return {"things": [(classes[box[0]], *map(float, box[1:])) for box in boxes]}

    return read_picture


def _open_on(
    file: str, wanted: str
) -> tuple[Callable[[NDArray[np.float32]], Sequence[NDArray[np.float32]]], str]:
    """Open a network on what is wanted, else on the processor, with why."""
    if wanted != CPU:
        try:
            return open_network(file, parse_provider(wanted)), ""
        except DetectorError as error:
            # A robot that holds back for people must see them, if slowly.
            return open_network(file, parse_provider(CPU)), error_text(error)
    return open_network(file, parse_provider(CPU)), ""


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
