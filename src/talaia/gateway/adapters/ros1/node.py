"""The process of the ROS 1 node: started, told and heard through pipes, and ended."""

from __future__ import annotations

import asyncio
import logging
import os
import select
import subprocess
import threading
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.gateway.adapters.ros1.frames import FrameSplitter, frame_of
from talaia.gateway.errors import AdapterLost

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.gateway.adapters.ros1.frames import ReceivedFrame
    from talaia.model.connection import Ros1Connection

__all__ = ["NodeProcess", "environment_of"]

log = logging.getLogger(__name__)
_SCRIPT = Path(__file__).with_name("bridge.py")
# What waits for a node that does not read; beyond this it hangs.
_MAX_WAITING = 1024 * 1024
_TURN_S = 0.1
_END_S = 2.0
# What the ROS 2 wheels and a virtual environment leave for their own Python only.
_NOT_FOR_IT = (
    "LD_LIBRARY_PATH",
    "_ROS_WHEELS_BOOTSTRAP_COMPLETE",
    "VIRTUAL_ENV",
    "PYTHONHOME",
)


def environment_of(uri: str, ours: Mapping[str, str]) -> dict[str, str]:
    """Give the environment of the node: ours, without what is for our Python only."""
    kept = {key: value for key, value in ours.items() if key not in _NOT_FOR_IT}
    return {**kept, "ROS_MASTER_URI": uri}


class NodeProcess:
    """One run of the node's process. Made and told on the event loop."""

    def __init__(
        self,
        *,
        settings: Ros1Connection,
        uri: str,
        heard: Callable[[ReceivedFrame], None],
        turned: Callable[[], None],
        failed: Callable[[str], None],
    ) -> None:
        """Start it.

        Args:
            settings: which interpreter runs it.
            uri: of the master.
            heard: takes every frame, on a thread of this process.
            turned: is called on that thread after frames, and at least every 0.1 s.
            failed: is called on that thread, once, when there will be no more frames.

        Raises:
            AdapterLost: there is no such interpreter.

        """
        self._loop = asyncio.get_running_loop()
        self._heard, self._turned, self._failed = heard, turned, failed
        try:
            # A group of its own: the gateway says the zeros before this ends, also on Ctrl-C.
            self._process = subprocess.Popen(  # noqa: S603 - an interpreter the description names
                [settings.python, "-u", str(_SCRIPT)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                env=environment_of(uri, os.environ),
                start_new_session=True,
            )
        except OSError as error:
            raise AdapterLost(f"{settings.python} cannot be run: {error.strerror}") from error
        assert self._process.stdin is not None  # noqa: S101 - asked for above
        assert self._process.stdout is not None  # noqa: S101
        self._in, self._out = self._process.stdin.fileno(), self._process.stdout.fileno()
        os.set_blocking(self._in, False)
        self._waiting = bytearray()
        self._writing = False
        self._ended = False
        self._last_words = ""
        self._threads = [
            threading.Thread(target=work, name=name, daemon=True)
            for work, name in (
                (self._read_loop, "talaia-ros1"),
                (self._log_errors, "talaia-ros1-log"),
            )
        ]
        for thread in self._threads:
            thread.start()

    # ── to it, on the event loop ──

    def send_frame(self, **what: object) -> None:
        """Send a frame; never waits."""
        if self._ended:
            return
        self._waiting += frame_of(what)
        self._flush_output()

    def _flush_output(self) -> None:
        try:
            while self._waiting:
                del self._waiting[: os.write(self._in, self._waiting[:65_536])]
        except BlockingIOError:
            pass
        except OSError:
            # It has ended; the reading thread tells of it.
            self._waiting.clear()
        if len(self._waiting) > _MAX_WAITING:
            self.kill_process()
        wanted = bool(self._waiting) and not self._ended
        if wanted and not self._writing:
            self._loop.add_writer(self._in, self._flush_output)
        elif self._writing and not wanted:
            self._loop.remove_writer(self._in)
        self._writing = wanted

    # ── from it, on threads ──

    def _read_loop(self) -> None:
        reader, why = FrameSplitter(), ""
        try:
            while True:
                if select.select([self._out], [], [], _TURN_S)[0]:
                    data = os.read(self._out, 1 << 20)
                    if not data:
                        break
                    for frame in reader.split_data(data):
                        self._heard(frame)
                self._turned()
        except AdapterLost as error:
            why = str(error)
        except Exception as error:  # a thread's last word: whatever it was, it must be told
            log.exception("the ROS 1 thread failed")
            why = f"{type(error).__name__}: {error}"
        self._failed(why or f"ROS 1's node ended ({self._last_words or 'without a word'})")

    def _log_errors(self) -> None:
        assert self._process.stderr is not None  # noqa: S101 - asked for above
        for line in self._process.stderr:
            text = line.decode("utf-8", "replace").rstrip()
            if text.strip():
                self._last_words = text.strip()[:500]
                log.debug("node: %s", text[:2000])

    # ── its end ──

    def kill_process(self) -> None:
        """End it at once."""
        self._process.kill()

    def hang_up(self) -> None:
        """Say no more; it says its zeros and ends. On the event loop; `wait_ended` follows."""
        if self._writing:
            self._loop.remove_writer(self._in)
            self._writing = False
        self._ended = True
        assert self._process.stdin is not None  # noqa: S101 - asked for above
        # Its buffer is empty: all was written past it.
        self._process.stdin.close()

    def wait_ended(self) -> None:
        """Wait until it has ended; kill it if it does not. Blocks."""
        try:
            self._process.wait(_END_S)
        except subprocess.TimeoutExpired:
            self.kill_process()
            self._process.wait()
        for thread in self._threads:
            thread.join(_END_S)
        for pipe in (self._process.stdout, self._process.stderr):
            if pipe is not None:
                pipe.close()
