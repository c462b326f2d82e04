"""The gateway's side of its watchdog: starts the process, feeds it, and dismisses it."""

from __future__ import annotations

import asyncio
import contextlib
import fcntl
import json
import logging
import os
import select
import signal
import socket
import subprocess
import sys
import time
from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.watchdog.child import ALREADY
from talaia.gateway.watchdog.closing import ClosingJob, WatchdogRecord

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from talaia.gateway.notices.settings import NoticeSettings
    from talaia.model.site import Site

__all__ = ["WatchdogClient", "dismiss_watchdog", "taken_records"]

log = logging.getLogger(__name__)
# A watchdog that is asked to leave ends what it has begun; after this it is killed.
LEAVE_S = 5.0
START_S = 10.0
# One that died is begun anew, no sooner than this.
AGAIN_S = 5.0
# Kept unread on the line at the most; a watchdog that stands still must not hold up the gateway.
MOST_UNSENT = 16 * 1024 * 1024


def dismiss_watchdog(lock: Path) -> bool:
    """End the watchdog that an earlier run of this gateway left, and what it is doing.

    Blocks until it has ended. Gives whether there was one.
    """
    try:
        file = _open_lock(lock)
    except OSError:
        return False
    try:
        if _acquire_lock(file):
            return False
        pid = _lock_holder(file)
        if not pid:
            return False
        with contextlib.suppress(ProcessLookupError):
            process = os.pidfd_open(pid)
            try:
                if _acquire_lock(file):
                    return True
                for number in (signal.SIGTERM, signal.SIGKILL):
                    signal.pidfd_send_signal(process, number)
                    # A frozen one hears nothing else.
                    signal.pidfd_send_signal(process, signal.SIGCONT)
                    if select.select([process], [], [], LEAVE_S)[0]:
                        break
            finally:
                os.close(process)
    except (OSError, ValueError) as error:
        log.warning("an older watchdog cannot be ended: %s", error)
        return False
    finally:
        os.close(file)
    return True


def _open_lock(lock: Path) -> int:
    """Open its file; a disk that can only be read keeps no old watchdog alive."""
    try:
        return os.open(lock, os.O_RDWR | os.O_CLOEXEC)
    except FileNotFoundError:
        raise
    except OSError:
        return os.open(lock, os.O_RDONLY | os.O_CLOEXEC)


def _lock_holder(file: int) -> int:
    """Give the number of the process that holds the lock; 0 when it has just let go."""
    for _ in range(100):
        # It writes its number a moment after it has the lock, and blanks before that.
        if number := os.pread(file, 20, 0).strip():
            return int(number)
        if _acquire_lock(file):
            return 0
        time.sleep(0.02)
    raise ValueError("it has left no process number")


def _acquire_lock(file: int) -> bool:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def taken_records(path: Path) -> list[WatchdogRecord]:
    """Give what a watchdog has written down, once."""
    try:
        lines = path.read_bytes().splitlines()
        path.unlink()
    except OSError:
        return []
    records = []
    for line in lines:
        with contextlib.suppress(msgspec.DecodeError):
            records.append(msgspec.json.decode(line, type=WatchdogRecord))
    return records


class WatchdogClient:
    """One gateway's watchdog. Event loop only."""

    def __init__(
        self,
        data: Path,
        folder: Path,
        domain: int | None,
        trouble: Callable[[str], None],
        *,
        notices: NoticeSettings | None = None,
    ) -> None:
        """Start nothing yet.

        Args:
            data: the gateway's data folder.
            folder: where the description stands.
            domain: a ROS domain that overrides the description's.
            trouble: told in words when there is no watchdog though there should be one.
            notices: ways to people; none where there are none.

        """
        self._lock = data / "watchdog.lock"
        self._record = data / "watchdog.jsonl"
        self._folder = folder
        self._domain = domain
        self._trouble = trouble
        self._notices = notices
        # Trouble is told once, until a watchdog runs again.
        self._said_trouble = False
        # To the process; none while there is none. It sees our death by the line's end.
        self._line: socket.socket | None = None
        # What the line did not take at once.
        self._unsent = b""
        # What the process is told first: how long to wait, and what to do then.
        self._setting = b""
        # After so long without a beat roofs are closed (s); 0: there is nothing to watch.
        self._after_s = 0.0
        # No start is tried again before this (s, monotonic).
        self._begin_s = 0.0
        # A start takes a while, and `keep_running` is called meanwhile.
        self._starting = False

    @property
    def wanted(self) -> bool:
        """Whether the description has an enclosure that it may close."""
        return self._after_s > 0

    def watch_site(self, site: Site, said: str) -> None:
        """Watch for this description (and its text) from here on."""
        times = [
            enclosure.watchdog_after
            for enclosure in site.enclosures.values()
            if enclosure.watchdog_after
        ]
        self._after_s = min(times, default=0.0)
        job = ClosingJob(
            description=said,
            folder=str(self._folder.resolve()),
            domain=self._domain,
            record=str(self._record.resolve()),
            notices=self._notices,
        )
        setting = {"after": self._after_s, "job": msgspec.to_builtins(job)}
        self._setting = json.dumps(setting).encode() + b"\n"
        if self._line is not None:
            self._send_bytes(self._setting)

    async def take_over(self) -> list[WatchdogRecord]:
        """End the watchdog of an earlier run; give what it has done."""
        if await asyncio.to_thread(dismiss_watchdog, self._lock):
            log.warning("the watchdog of an earlier run has been dismissed")
        return self.take_records()

    def take_records(self) -> list[WatchdogRecord]:
        """Give what watchdogs have done since this was last asked."""
        return taken_records(self._record)

    async def keep_running(self, now_s: float) -> None:
        """Start the process if there should be one and is none (``now_s``: monotonic)."""
        if not self.wanted or self._line is not None or self._starting or now_s < self._begin_s:
            return
        self._starting, self._begin_s = True, now_s + AGAIN_S
        try:
            problem = await self._start_process()
        finally:
            self._starting = False
        if problem and not self._said_trouble:
            self._said_trouble = True
            self._trouble(problem)

    async def _start_process(self) -> str:
        ours, theirs = socket.socketpair()
        words = [sys.executable, "-m", "talaia.gateway.watchdog.child", str(self._lock)]
        try:
            status = await asyncio.to_thread(
                subprocess.call,
                words,
                stdin=theirs.fileno(),
                stdout=subprocess.DEVNULL,
                timeout=START_S,
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            ours.close()
            return f"the watchdog process cannot be started: {error}"
        except asyncio.CancelledError:
            ours.close()
            raise
        finally:
            theirs.close()
        if status:
            ours.close()
            why = "another one runs" if status == ALREADY else f"it ended with {status}"
            return f"the watchdog process cannot be started: {why}"
        ours.settimeout(0)
        self._line, self._unsent, self._said_trouble = ours, b"", False
        self._send_bytes(self._setting)
        return ""

    def send_beat(self) -> None:
        """Give a sign of life; only after the interlocks have really been judged."""
        # What is under way says as much; a line that is full is not filled further.
        self._send_bytes(b"" if self._unsent else b'"beat"\n')

    def _send_bytes(self, data: bytes) -> None:
        if self._line is None:
            return
        self._unsent += data
        try:
            while self._unsent:
                sent = self._line.send(self._unsent)
                self._unsent = self._unsent[sent:]
        except BlockingIOError:
            if len(self._unsent) > MOST_UNSENT:
                self._close_line("it does not read")
        except OSError as error:
            self._close_line(str(error))

    def _close_line(self, why: str) -> None:
        if self._line is not None:
            self._line.close()
            self._line = None
        log.warning("the watchdog process was lost (%s); it is begun anew", why)

    def let_go(self) -> None:
        """Leave the process to the next run of this gateway, which takes over from it in time."""
        if self._line is not None:
            self._line.close()
            self._line = None

    async def end_process(self) -> None:
        """End the process: this gateway ends as it was asked to."""
        if self._line is None:
            return
        self._send_bytes(b'"goodbye"\n')
        self.let_go()
        await asyncio.to_thread(dismiss_watchdog, self._lock)
