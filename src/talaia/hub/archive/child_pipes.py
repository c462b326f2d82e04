"""A process that reads files of others, and the pipes to it; see `child_limits`.

A question and its answer go as bytes behind their length. One that does not answer in time, or says
nonsense, is ended, and begun anew for the next question.
"""

from __future__ import annotations

import contextlib
import os
import select
import struct
import subprocess
import sys
import threading
import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import BinaryIO

__all__ = ["ChildPipes", "read_question", "write_answer"]

_LENGTH = struct.Struct(">I")
# What a process needs of our surroundings; secrets of the hub's are not among it.
_SURROUNDINGS = ("PATH", "PYTHONPATH", "LANG", "HOME")
_PLAIN = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1"}


class ChildPipes:
    """See the module. Used from threads, one at a time."""

    def __init__(self, module: str, *, most_answer: int) -> None:
        """Begin ``python -m module`` for the first question; answers have so many bytes."""
        self._module = module
        self._most_answer = most_answer
        # Held while a file is read, by a thread that nobody may wait for any more.
        self._busy = threading.Lock()
        self._child: subprocess.Popen[bytes] | None = None

    def ask(self, question: Sequence[bytes], deadline: float) -> bytes:
        """Ask, and give the answer that comes until ``deadline`` (`time.monotonic`).

        Raises:
            TimeoutError: none comes in time.
            OSError: the process has ended.
            ValueError: the answer is too long.

        """
        with self._busy:
            try:
                return self._exchange(question, deadline)
            except (OSError, ValueError):
                self.end_process()
                raise

    def end_process(self) -> None:
        """End it, if there is one."""
        child, self._child = self._child, None
        if child is None:
            return
        child.kill()
        child.wait()
        for pipe in (child.stdin, child.stdout):
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()

    def _exchange(self, question: Sequence[bytes], deadline: float) -> bytes:
        child = self._child
        if child is None or child.poll() is not None:
            self.end_process()
            child = self._child = subprocess.Popen(  # noqa: S603 - our own module
                [sys.executable, "-m", self._module],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env={
                    **{name: os.environ[name] for name in _SURROUNDINGS if name in os.environ},
                    **_PLAIN,
                },
            )
        if child.stdin is None or child.stdout is None:
            raise OSError("it has no pipes")
        child.stdin.write(_LENGTH.pack(sum(map(len, question))))
        for part in question:
            child.stdin.write(part)
        child.stdin.flush()
        out = child.stdout.fileno()
        (size,) = _LENGTH.unpack(_read_whole(out, _LENGTH.size, deadline))
        if size > self._most_answer:
            raise ValueError(f"an answer of {size} bytes")
        return _read_whole(out, size, deadline)


def read_question(asked: BinaryIO) -> bytes | None:
    """Read a question, in the process; None when there are no more."""
    head = asked.read(_LENGTH.size)
    return asked.read(_LENGTH.unpack(head)[0]) if len(head) == _LENGTH.size else None


def write_answer(answers: BinaryIO, *parts: bytes) -> None:
    """Write an answer, in the process."""
    answers.write(_LENGTH.pack(sum(map(len, parts))))
    for part in parts:
        answers.write(part)
    answers.flush()


def _read_whole(number: int, size: int, deadline: float) -> bytes:
    """Read so many bytes of a pipe, unless they do not come in time."""
    poll = select.poll()
    poll.register(number, select.POLLIN)
    parts = bytearray()
    while len(parts) < size:
        if not poll.poll(max(0.0, deadline - time.monotonic()) * 1000):
            raise TimeoutError
        part = os.read(number, size - len(parts))
        if not part:
            raise OSError("it has ended")
        parts += part
    return bytes(parts)
