"""The watchdog's process: ``python -m talaia.gateway.watchdog.child LOCK``.

It hears the gateway's beats on its input, one JSON value a line: ``"beat"``, ``"goodbye"``, or
``{"after": seconds, "job": …}`` with what is needed to close. When they cease it starts `closing`,
which knows the robot's protocol, and ends that when the gateway is back. It leaves the gateway's
session and process group, so that what ends the gateway does not end it. SIGTERM is a goodbye.

Standard library only: it waits for years and should take no memory.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import select
import signal
import subprocess
import sys
import time

from talaia.gateway.watchdog.silence_timer import SilenceTimer, WatchdogTask

__all__ = ["ALREADY", "main"]

# Exit status: another watchdog of this data folder runs.
ALREADY = 3
# A quarter second, for the shortest `watchdog_after` is seconds.
LOOK_S = 0.25
# What closes gets this long to end by itself (end of input, SIGTERM) before it is killed.
END_S = 2.0
# s; doubled after each failure.
FIRST_AGAIN_S, LONGEST_AGAIN_S = 1.0, 30.0
# A description is at most 4 MiB, escaped.
MOST_LINE = 16 * 1024 * 1024


def main(argv: list[str]) -> int:
    """Watch until the gateway says goodbye, or is dead and all is closed."""
    # flock, not the file's being there: the kernel frees it when a process dies, however that
    # happens.
    try:
        lock = os.open(argv[0], os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        _log_message(f"cannot be begun: {argv[0]}: {error.strerror}")
        return ALREADY
    # Whose number stood here has ended: it held the lock.
    # Between here and the second number nobody may be signalled by an old one.
    _write_number(lock, "")
    # Whoever started this waits for the first process; the second one belongs to nobody.
    if os.fork():
        os._exit(0)
    with contextlib.suppress(OSError):
        os.setsid()
    # Who takes over signals this number while the lock is held; see `feeding.dismiss_watchdog`.
    _write_number(lock, str(os.getpid()))
    # Ctrl-C and a closed terminal are meant for the gateway; a broken pipe is read as its end.
    for ignored in (signal.SIGINT, signal.SIGHUP, signal.SIGPIPE):
        signal.signal(ignored, signal.SIG_IGN)
    WatchdogProcess(os.dup(0), argv[0]).run()
    return 0


def _write_number(lock: int, number: str) -> None:
    """Write who holds the lock; on a full disk nobody knows, and it watches all the same."""
    with contextlib.suppress(OSError):
        os.pwrite(lock, f"{number:<20}".encode(), 0)


class WatchdogProcess:
    """Hears, judges, and has closed."""

    def __init__(self, line: int, lock: str) -> None:
        """Listen on a file descriptor; without the file ``lock`` there is no such gateway more."""
        # Path of the lock file; removed with the data folder, which ends this process.
        self._lock = lock
        os.set_blocking(line, False)
        self._line: int | None = line  # The gateway's end of a pipe; None once it has ended.
        self._waiting = b""  # A line that has not come whole yet.
        self._silence = SilenceTimer(time.monotonic())  # Judges by beats; see `SilenceTimer`.
        # What to close, passed on as it came; None before the gateway has said it.
        self._job: object = None
        # The process that closes, while there is one.
        self._closing: subprocess.Popen[bytes] | None = None
        # Not before this (monotonic s), and how long to wait after the next failure.
        self._begin_s, self._again_s = 0.0, FIRST_AGAIN_S
        # Failures in a row and how the last ended: the next one tells people of it.
        self._failures, self._failed = 0, ""
        signal.signal(signal.SIGTERM, lambda *_: self._silence.hear_goodbye())

    def run(self) -> None:
        """Go on until there is nothing to watch."""
        try:
            while (task := self._silence.judge_silence(time.monotonic())) is not WatchdogTask.LEAVE:
                if task is WatchdogTask.CLOSE:
                    self._keep_closing()
                else:
                    self._end_closing()
                self._listen_to_gateway()
        finally:
            self._end_closing()

    def _listen_to_gateway(self) -> None:
        if self._line is None:
            time.sleep(LOOK_S)
            # The gateway is dead and its data folder gone: nothing left that could be closed for
            # it.
            if not os.path.exists(self._lock):
                self._silence.hear_goodbye()
            return
        # Its time-out is the loop's pace: a beat wakes it sooner.
        if not select.select([self._line], [], [], LOOK_S)[0]:
            return
        try:
            data = os.read(self._line, 1 << 20)
        except BlockingIOError:
            return
        # A broken line is an end like any other.
        except OSError:
            data = b""
        if not data:
            self._silence.hear_end()
            os.close(self._line)
            self._line = None
            return
        *lines, self._waiting = (self._waiting + data).split(b"\n")
        for line in lines:
            self._read_message(line)
        # No newline in 16 MiB is no message; keep what follows it readable.
        if len(self._waiting) > MOST_LINE:
            self._waiting = b""

    def _read_message(self, line: bytes) -> None:
        try:
            said = json.loads(line)
        # Half a line from a gateway that died while writing.
        except ValueError:
            return
        if said == "beat":
            self._silence.hear_beat()
        elif said == "goodbye":
            self._silence.hear_goodbye()
        elif isinstance(said, dict):
            self._silence.after_s = float(said["after"])
            self._job = said["job"]

    def _keep_closing(self) -> None:
        """Have it closed; what fails is begun again, later each time."""
        now = time.monotonic()
        if self._closing is None:
            if now < self._begin_s:
                return
            _log_message(
                "the gateway is dead or stands still"
                f" (nothing heard for {self._silence.silent_s:.2f} s):"
                " closing by the enclosures' own commands"
            )
            self._closing = subprocess.Popen(
                [sys.executable, "-m", "talaia.gateway.watchdog.closing"],
                stdin=subprocess.PIPE,
            )
            job = self._job
            if isinstance(job, dict):
                # People are told of it, too.
                job = {**job, "failures": self._failures, "failed": self._failed}
            with contextlib.suppress(OSError):
                # It may have died already; `poll` says so at the next look.
                self._closing.stdin.write(json.dumps(job).encode() + b"\n")  # type: ignore[union-attr]
                self._closing.stdin.flush()  # type: ignore[union-attr]
            return
        status = self._closing.poll()
        # Still at work.
        if status is None:
            return
        self._end_closing()
        if status == 0:
            self._again_s, self._failures = FIRST_AGAIN_S, 0
            self._silence.report_closed()
            return
        self._failures += 1
        self._failed = f"ended by signal {-status}" if status < 0 else f"exit code {status}"
        _log_message(f"closing failed ({self._failed}); again in {self._again_s:g} s")
        self._begin_s = now + self._again_s
        self._again_s = min(LONGEST_AGAIN_S, 2 * self._again_s)

    def _end_closing(self) -> None:
        """End what closes, and wait until it has ended: two must never move a roof."""
        closing, self._closing = self._closing, None
        if closing is None:
            return
        if closing.stdin is not None:
            with contextlib.suppress(OSError):
                closing.stdin.close()
        if closing.poll() is None:
            _log_message("the gateway is back, or has ended as it was asked to: closing no more")
            closing.terminate()
            try:
                closing.wait(END_S)
            except subprocess.TimeoutExpired:
                closing.kill()
                closing.wait()


def _log_message(message: str) -> None:
    # Whoever read this may be gone, too.
    with contextlib.suppress(OSError):
        sys.stderr.write(f"talaia watchdog: {message}\n")
        sys.stderr.flush()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
