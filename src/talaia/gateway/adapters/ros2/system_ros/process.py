"""The bridge process: started by the system ROS's own Python, asked and heard through pipes.

One for all connections of a gateway. Questions wait for their answer; messages to publish do not
wait: a thread writes them. When it ends, whoever waits for anything of it is told.
"""

from __future__ import annotations

import json
import logging
import os
import subprocess
import threading
from collections import deque
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from talaia.gateway.adapters.ros2.rclpy_bridge.pipe_frames import (
    ANSWER,
    JSON,
    MESSAGE,
    MESSAGE_HEAD,
    NUMBERED_HEAD,
    json_frame,
    read_frames,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

__all__ = ["BRIDGE_SCRIPT", "BridgeLost", "BridgeProcess", "Receiver"]

log = logging.getLogger(__name__)
BRIDGE_SCRIPT = Path(__file__).parent.parent / "bridge.py"
# rclpy's imports from a memory card.
_START_S = 30.0
_ANSWER_S = 10.0
_END_S = 4.0
# What may wait to be written: a bridge that does not read so much hangs.
_MAX_WAITING = 16 * 1024 * 1024


class BridgeLost(RuntimeError):
    """The bridge process has ended, or does not answer; as rclpy's own errors."""


class Receiver(Protocol):
    """Who takes what comes for an entity, on the reading thread."""

    def on_message(self, raw: bytes, received_ns: int, sent_ns: int, number: int) -> None:
        """Take a topic's message."""
        ...

    def on_answer(self, raw: bytes, number: int) -> None:
        """Take the answer to a call."""
        ...

    def on_lost(self) -> None:
        """Learn that nothing comes any more."""
        ...


class _Question:
    """A question under way."""

    def __init__(self) -> None:
        self.done = threading.Event()
        self.answer: dict[str, Any] = {}


class BridgeProcess:
    """One run of it. Any thread."""

    def __init__(self, command: Sequence[str], environment: Mapping[str, str]) -> None:
        """Start it and wait until rclpy is imported there.

        Raises:
            BridgeLost: it cannot be started, or has no rclpy.

        """
        try:
            # A group of its own: the gateway ends it, also on Ctrl-C.
            self._process = subprocess.Popen(  # noqa: S603 - an interpreter of the system's
                [*command, str(BRIDGE_SCRIPT)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                env=dict(environment),
                start_new_session=True,
            )
        except OSError as error:
            raise BridgeLost(f"{command[0]} cannot be run: {error.strerror}") from error
        # What it said of itself at its start: packages, middleware, Python.
        self.hello: dict[str, Any] = {}
        # Why it has ended; empty while it runs.
        self.lost = ""
        self._ready = threading.Event()
        self._numbers = count(1)
        self._questions: dict[int, _Question] = {}
        self._receivers: dict[int, Receiver] = {}
        # Frames that have not been written; guarded by the condition that follows.
        self._waiting: deque[bytes] = deque()
        self._size = 0
        self._to_write = threading.Condition()
        self._closing = False
        self._last_words = ""
        for work, name in (
            (self._read_loop, "talaia-ros2-bridge"),
            (self._write_loop, "talaia-ros2-bridge-out"),
            (self._log_errors, "talaia-ros2-bridge-log"),
        ):
            threading.Thread(target=work, name=name, daemon=True).start()
        if not self._ready.wait(_START_S) or self.lost:
            self.kill()
            raise BridgeLost(self.lost or f"it does not start ({self._last_words})")

    # ── to it ──

    def next_number(self) -> int:
        """Give a number that nothing else has."""
        return next(self._numbers)

    def register(self, number: int, receiver: Receiver) -> None:
        """Take who is told of an entity, or of the end."""
        self._receivers[number] = receiver

    def forget(self, number: int) -> None:
        """Tell nobody any more."""
        self._receivers.pop(number, None)

    def ask(self, question: str, /, **words: object) -> Any:  # noqa: ANN401 - what was asked for
        """Ask, and wait for the answer; see the methods ``do_…`` of `rclpy_bridge.main.Bridge`.

        Raises:
            BridgeLost: it has ended, or does not answer.
            RuntimeError: ROS refuses it.

        """
        number, asked = self.next_number(), _Question()
        self._questions[number] = asked
        self.send(json_frame({"do": question, "call": number, **words}))
        # One that ended before the question was there has told nobody of it.
        answered = bool(self.lost) or asked.done.wait(_ANSWER_S)
        self._questions.pop(number, None)
        if self.lost:
            raise BridgeLost(self.lost)
        if not answered:
            self.kill()
            raise BridgeLost("the process of the system's ROS 2 does not answer; it is ended")
        if "error" in asked.answer:
            raise RuntimeError(asked.answer["error"])
        return asked.answer["result"]

    def send(self, frame: bytes) -> None:
        """Send a frame; never waits."""
        with self._to_write:
            self._waiting.append(frame)
            self._size += len(frame)
            hangs = self._size > _MAX_WAITING
            self._to_write.notify()
        if hangs:
            self.kill()

    def close(self) -> None:
        """End it; it publishes zeros and leaves. Blocks."""
        with self._to_write:
            self._closing = True
            self._to_write.notify()
        try:
            self._process.wait(_END_S)
        except subprocess.TimeoutExpired:
            self.kill()
            self._process.wait()

    def kill(self) -> None:
        """End it at once."""
        self._process.kill()

    # ── threads ──

    def _write_loop(self) -> None:
        assert self._process.stdin is not None  # noqa: S101 - asked for above
        pipe = self._process.stdin.fileno()
        while True:
            with self._to_write:
                self._to_write.wait_for(lambda: self._waiting or self._closing or self.lost)
                # In one write: a wake-up for each frame would cost more than the frames.
                data = memoryview(b"".join(self._waiting))
                self._waiting.clear()
                self._size = 0
                over = self._closing or bool(self.lost)
            try:
                while data:
                    data = data[os.write(pipe, data) :]
                if over:
                    self._process.stdin.close()
                    return
            except OSError:
                # It has ended; the reading thread tells of it.
                return

    def _read_loop(self) -> None:
        assert self._process.stdout is not None  # noqa: S101 - asked for above
        try:
            for kind, body in read_frames(self._process.stdout):
                self._on_frame(kind, body)
        except Exception:  # a thread's last word; what follows is told below
            log.exception("the thread of the system's ROS 2 failed")
        self._process.stdout.close()
        # It may be a moment before its number of exit is known.
        code = self._process.poll()
        words = self._last_words or ("without a word" if code is None else f"with {code}")
        self.lost = f"the process of the system's ROS 2 ended ({words})"
        self._ready.set()
        for question in list(self._questions.values()):
            question.done.set()
        for receiver in list(self._receivers.values()):
            receiver.on_lost()
        with self._to_write:
            self._to_write.notify()

    def _on_frame(self, kind: int, body: bytes) -> None:
        if kind == MESSAGE:
            entity, received_ns, sent_ns, number = MESSAGE_HEAD.unpack_from(body)
            receiver = self._receivers.get(entity)
            if receiver is not None:
                receiver.on_message(body[MESSAGE_HEAD.size :], received_ns, sent_ns, number)
        elif kind == ANSWER:
            entity, number = NUMBERED_HEAD.unpack_from(body)
            receiver = self._receivers.get(entity)
            if receiver is not None:
                receiver.on_answer(body[NUMBERED_HEAD.size :], number)
        elif kind == JSON:
            told = json.loads(body)
            if "hello" in told:
                self.hello = told
                self._ready.set()
            elif (question := self._questions.get(told["call"])) is not None:
                question.answer = told
                question.done.set()

    def _log_errors(self) -> None:
        assert self._process.stderr is not None  # noqa: S101 - asked for above
        for line in self._process.stderr:
            text = line.decode("utf-8", "replace").rstrip()
            if text.strip():
                self._last_words = text.strip()[:500]
                log.debug("bridge: %s", text[:2000])
        self._process.stderr.close()
